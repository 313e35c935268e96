"""The Omnipuck's driver: serial protocol, wheel kinematics, and the node that connects the robot to the graph."""
