"""Conversion between records of collplan_core and ROS messages, motion-capture formats, QoS profiles."""
