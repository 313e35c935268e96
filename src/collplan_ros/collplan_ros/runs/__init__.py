"""Recording of runs, their result files, and reading them back; only the recorder needs ROS."""
