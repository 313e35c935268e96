"""What is kept of a run, and reading it back."""
