"""The program replay: a recorded run given to planner and controller again, without ROS."""
