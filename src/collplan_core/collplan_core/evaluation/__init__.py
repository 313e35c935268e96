"""Figures of a run: foreseen impacts, path length, and how it ended."""
