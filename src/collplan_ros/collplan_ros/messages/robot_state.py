"""The states of a robot on the topic robot/state."""

FREE, HELD, STOPPED = "free", "held", "stopped"
"""It follows commands; it waits for a person; its emergency stop is latched."""
