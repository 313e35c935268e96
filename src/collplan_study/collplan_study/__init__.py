"""The study: grids of simulated trials, their tables, their analysis and their report."""
