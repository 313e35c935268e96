"""Estimates a LIDAR's place, stamp delay and beam order from the scans and poses of a moving robot."""
