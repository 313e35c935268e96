"""Decision loops of planner and controller, on poses, scans, plans and a time; run by nodes and trials alike."""
