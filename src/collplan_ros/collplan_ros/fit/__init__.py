"""Fits the robot's drive and rebound to recorded runs."""
