"""Faults done to the robot's graph on purpose, and how long it takes until the robot stands: `make faults`."""
