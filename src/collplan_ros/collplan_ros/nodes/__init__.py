"""The ROS nodes of the control loop, and the parts they are composed of."""
