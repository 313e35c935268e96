"""RViz markers of local map, candidates and plan."""
