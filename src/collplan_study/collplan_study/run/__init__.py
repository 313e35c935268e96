"""Running the trials of a study, and keeping what they give."""
