"""Tracking a reference, and the rules by which the robot stands still."""
