"""Boundaries remembered from earlier scans, and how far the disc is from touching them."""
