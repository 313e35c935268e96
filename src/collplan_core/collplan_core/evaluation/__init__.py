"""How a run went: matched impacts, path length, and its end."""
