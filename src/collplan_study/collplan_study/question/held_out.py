"""Held-out worlds and noise: nothing was tuned on them, and each set of seeds is run once.

Tuning takes worlds with seeds below 1000 and other study seeds. A set is committed before its first run; once its
results were seen it is spent, and what is changed afterwards needs another. Spent: worlds 1000 to 1023 at study seed
61, before pymunk computed the contacts; 20000 to 20023 at 62 and 21000 to 21023 at 63, before plans were smooth. Beside
the worlds below, `corridor` and random:20200-20399 at STUDY_SEED are held out for the paper's strategies, and worlds
22000 to 22023 at 64 for the comparison with the optimum (studies/optimum).
"""

FIRST_SEED = 23000
LAST_SEED = 23023
"""Seeds of the 24 worlds of each family below, both inclusive."""

FAMILIES = ("l", "u", "z", "baffles", "random")
"""Families pooled in the headline comparison."""
FURTHER_FAMILIES = ("serpentine", "pillars")
"""Families compared one by one."""

STUDY_SEED = 65
"""Seed of the study, from which each trial's noise follows."""
TRIALS = 2
"""Runs in each world, with different noise."""


def held_out_worlds(family: str) -> str:
    """The held-out worlds of a family as `--worlds` takes them."""
    return f"{family}:{FIRST_SEED}-{LAST_SEED}"
