"""Movers: found in scans, followed, and a check that keeps the robot from driving into them."""
