"""The study: a grid of simulated trials in one command, each reproducible, none lost."""
