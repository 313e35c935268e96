"""The ROS nodes of the loop, and what each is composed of."""
