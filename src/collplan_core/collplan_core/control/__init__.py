"""Tracking of a reference, and the rules that let the robot move."""
