"""The drive of the robot, learnt from commands and poses while it drives."""
