"""From measured poses to the robot's state and the impacts it met."""
