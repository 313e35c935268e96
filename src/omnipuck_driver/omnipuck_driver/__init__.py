"""Place of the Omnipuck's serial driver: protocol, wheel kinematics and the node that speaks to the robot.

Empty so far: the robot of this version is the simulated one of `omnipuck_sim`, behind the same topics.
"""
