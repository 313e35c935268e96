"""Rollouts of the robot's own law to the goal, with what they run into on the way, and the choice among them."""
