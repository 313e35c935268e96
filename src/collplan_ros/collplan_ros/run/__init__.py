"""run.mcap: every topic of a run as it was sent; only what listens to the graph needs ROS."""
