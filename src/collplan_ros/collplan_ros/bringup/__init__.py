"""Starts the graph, gives the goal, watches, records, and ends everything."""
