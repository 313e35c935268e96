"""Scans on their way to a map: filtered, placed among the poses, denoised, and compared with those before."""
