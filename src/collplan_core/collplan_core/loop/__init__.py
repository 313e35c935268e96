"""What planner and controller decide, on poses, scans, plans and a time: fed by the nodes and by trials alike."""
