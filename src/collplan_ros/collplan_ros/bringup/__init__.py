"""The program bringup: starts the nodes, gives the goal, monitors and records the run, and stops everything."""
