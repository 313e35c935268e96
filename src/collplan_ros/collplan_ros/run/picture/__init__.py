"""The picture of a recorded run, made without ROS."""
