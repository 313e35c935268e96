"""From measured poses to the robot's state and its impacts."""
