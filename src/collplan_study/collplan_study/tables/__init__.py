"""One row a run, and tables of rows."""
