"""How long it takes from anywhere to the goal, over what is known."""
