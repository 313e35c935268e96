"""Held-out worlds and noise: nothing was tuned on them, and each set of seeds is run once.

Tuning takes worlds with seeds below 1000 and other study seeds. A set is committed before its first run; once its
results were seen it is spent, and what is changed afterwards needs another. Spent: worlds 1000 to 1023 at study seed
61, before pymunk computed the contacts; 20000 to 20023 and random:20200-20399 at 62 and 21000 to 21023 at 63, before
plans were smooth; 22000 to 22023 at 64 and 23000 to 23023 at 65, before the delay of commands was known; 24000 to 24023
and random:20400-20719 at 66, of version 1.0.0, 26000 to 26011 at 67, after it, and 27000 to 27023 and
random:27200-27519 at 68, of version 1.1.0.
"""

FIRST_SEED = 28000
LAST_SEED = 28023
"""Seeds of the 24 worlds of each family below, both inclusive."""

FAMILIES = ("l", "u", "z", "baffles", "random")
"""Families pooled in the headline comparison."""
FURTHER_FAMILIES = ("serpentine", "pillars", "posts")
"""Families compared one by one."""

PAPER_WORLDS = "random:28200-28399"
PERIOD_WORLDS = "random:28400-28499"
ABLATION_WORLDS = "random:28500-28519"
"""Worlds for the paper's strategies: at the shipped T_map, at each T_map, and with the ablations."""

STUDY_SEED = 69
"""Seed of the study, from which each trial's noise follows."""
TRIALS = 2
"""Runs in each world, with different noise."""


def held_out_worlds(family: str, count: int = LAST_SEED - FIRST_SEED + 1) -> str:
    """The first so many held-out worlds of a family, all of them by default, as `--worlds` takes them."""
    return f"{family}:{FIRST_SEED}-{FIRST_SEED + count - 1}"
