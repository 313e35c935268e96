"""The question of a study: strategies, worlds, seeds, parameters."""
