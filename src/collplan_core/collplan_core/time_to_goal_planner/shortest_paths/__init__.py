"""Shortest any-angle paths to the goal, and the time to go along them."""
