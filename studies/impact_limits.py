"""What a limit of the impact speed costs in time: paired trials of a time-to-goal strategy in development worlds.

    .venv/bin/python studies/impact_limits.py --out runs/impact_limits.jsonl

One trial a world and limit, with equal noise. Rows are appended as they come, and one that is there is not run again.
Prints a table for docs/bounces.md. Simulated.
"""

import argparse
import sys
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import numpy as np

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings
from collplan_core.worlds import load_world
from collplan_study.analysis.statistics import MEAN, Estimate, improvement
from collplan_study.run.json_lines import JsonLines
from omnipuck_sim.trial import run_trial

FAMILIES = ("serpentine", "u", "baffles", "random")
LIMITS = (1.2, 1.0, 0.8, 0.6)
"""[m/s], the first one is what the others are compared with."""
SEED = 1


def row_of(world: str, limit: float, strategy: str) -> dict[str, object]:
    """One trial: how it ended, when [s], and its hardest impact [m/s]."""
    settings = Settings().with_values({"planner.strategy": strategy, "limits.impact_speed": limit})
    result = run_trial(load_world(world), settings, SEED)
    speeds = [-float(impact.velocity_before @ impact.normal) for impact in result.impacts]
    measured = {"outcome": result.outcome, "time": result.arrival_time, "hardest": max(speeds, default=0.0)}
    return {"world": world, "limit": limit, "strategy": strategy, **measured}


def table(rows: Sequence[dict], strategy: str) -> str:
    """A line a family and limit: how many arrived, mean time, what the limit costs, median of the hardest impacts."""
    lines = [
        "| worlds | limit [m/s] | reached | time [s] | longer than at 1.2 m/s [%] | hardest impact [m/s] |",
        "|---|---|---|---|---|---|",
    ]
    found = {(row["world"], row["limit"]): row for row in rows if row["strategy"] == strategy}
    for family in (*FAMILIES, "all"):
        worlds = [w for w, limit in found if limit == LIMITS[0] and (family == "all" or w.startswith(f"{family}:"))]
        for limit in LIMITS:
            here = {world: found[world, limit] for world in worlds if (world, limit) in found}
            both = [w for w, row in here.items() if row["outcome"] == found[w, LIMITS[0]]["outcome"] == REACHED]
            times = [[np.array([found[world, each]["time"]]) for world in both] for each in (limit, LIMITS[0])]
            cost = "" if limit == LIMITS[0] else _in_words(improvement(MEAN, *times).negated())
            hardest = np.median([row["hardest"] for row in here.values()]) if here else np.nan
            reached = sum(row["outcome"] == REACHED for row in here.values())
            mean = np.mean(times[0]) if both else np.nan
            lines.append(f"| {family} | {limit:g} | {reached} of {len(here)} | {mean:.2f} | {cost} | {hardest:.2f} |")
    return "\n".join(lines)


def _in_words(cost: Estimate) -> str:
    if cost.value is None or cost.low is None:
        return cost.note
    return f"{cost.value:.1f} [{cost.low:.1f}, {cost.high:.1f}]"


def main(args: Sequence[str] | None = None) -> int:
    """Runs what is not there yet, and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="rows, one trial a line")
    parser.add_argument("--worlds", type=int, default=8, help="worlds of each family, seeds from 300 on (default 8)")
    parser.add_argument("--strategy", default="bounce", help="a time-to-goal strategy (default bounce)")
    given = parser.parse_args(args)
    out = JsonLines(given.out)
    there = {(row["world"], row["limit"], row["strategy"]) for row in out.records()}
    for seed, family, limit in product(range(300, 300 + given.worlds), FAMILIES, LIMITS):
        if (f"{family}:{seed}", limit, given.strategy) not in there:
            out.append(row_of(f"{family}:{seed}", limit, given.strategy))
    print(table(out.records(), given.strategy))
    return 0


if __name__ == "__main__":
    sys.exit(main())
