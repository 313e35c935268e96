"""Records of collplan_core as ROS messages and back, foreign mocap formats, QoS profiles."""
