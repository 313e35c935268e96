"""Pictures and animations of recorded runs, made without ROS."""
