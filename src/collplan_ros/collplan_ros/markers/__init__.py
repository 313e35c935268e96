"""What the planner saw and chose, as RViz markers."""
