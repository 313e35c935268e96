"""Journal of planner and controller: written while they run, and replayed later."""
