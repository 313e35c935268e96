"""Statistics over the rows of a study."""
