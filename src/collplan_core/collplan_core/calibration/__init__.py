"""The robot's constants and the motion-capture offsets, estimated from recorded motion."""
