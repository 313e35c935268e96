"""The robot's firmware at the other end of a pseudo-terminal."""
