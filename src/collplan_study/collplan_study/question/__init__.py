"""What a study asks: strategies, worlds, seeds, settings."""
