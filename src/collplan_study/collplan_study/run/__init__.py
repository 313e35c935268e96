"""Runs the trials of a study and keeps their rows."""
