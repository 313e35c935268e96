"""The program inspect: what a recording of a robot tells of its sensors, without ROS."""
