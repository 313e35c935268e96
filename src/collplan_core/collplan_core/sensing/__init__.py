"""State and impacts of the robot from measured poses; scans, their plausibility and their noise."""
