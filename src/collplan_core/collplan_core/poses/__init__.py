"""State and impacts of the robot from measured poses, in their order in time."""
