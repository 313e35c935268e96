"""The live page: its frames, its access checks, and the page itself."""
