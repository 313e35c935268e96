"""Worlds and noise that nothing is tuned on: they are run once a design is frozen, and never looked at before.

Tuning takes worlds with seeds below FIRST_SEED and other study seeds. This file was committed before the first tuning
run of the strategies it judges; a change of it after that would void what was measured with it.
"""

FIRST_SEED = 1000
LAST_SEED = 1023
"""24 worlds of every family."""

FAMILIES = ("l", "u", "z", "baffles", "random")
"""Compared together."""
FURTHER_FAMILIES = ("serpentine", "pillars")
"""Compared each by itself."""

STUDY_SEED = 61
"""Seed of the study, from which each trial's noise follows."""
TRIALS = 2
"""Runs of each world with different noise."""


def held_out_worlds(family: str) -> str:
    """The worlds of a family as the study names them, both ends inclusive."""
    return f"{family}:{FIRST_SEED}-{LAST_SEED}"
