"""The journal of planner and controller: written while they run, and given to them again."""
