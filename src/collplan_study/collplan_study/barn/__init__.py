"""Worlds and scores of the BARN benchmark."""
