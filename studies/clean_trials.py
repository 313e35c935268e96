"""What checks of scans, poses and motion cost where nothing is wrong: trials of two states of the code, in pairs.

    .venv/bin/python studies/clean_trials.py --out runs/clean.jsonl
    PYTHONPATH=$(ls -d OLD/src/* | tr '\\n' ':') .venv/bin/python studies/clean_trials.py --out runs/clean_old.jsonl
    .venv/bin/python studies/clean_trials.py --compare runs/clean_old.jsonl runs/clean.jsonl

300 trials over the nine pairs of a shipped arena and a printed strategy, and 24 serpentines with bounce. Rows are
appended as they come, and one that is there is not run again. Prints a table for docs/reliability.md. Simulated.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from collplan_core.command import STOPPED
from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings
from collplan_core.strategies import PAPER_WEIGHTS
from collplan_core.worlds import load_world
from collplan_study.analysis.statistics import MEAN, improvement
from collplan_study.run.json_lines import JsonLines
from omnipuck_sim.trial import run_trial

PAIRS = [(world, strategy) for world in ("corridor", "l_corridor", "slalom") for strategy in PAPER_WEIGHTS]
SERPENTINES = [(f"serpentine:{seed}", "bounce", seed) for seed in range(24)]
CASES = [(*PAIRS[k % len(PAIRS)], k // len(PAIRS)) for k in range(300)] + SERPENTINES
"""World, strategy and seed of each trial."""


def row_of(world: str, strategy: str, seed: int, values: dict[str, str]) -> dict[str, object]:
    """One trial: how it ended, when [s], and for how many control periods the robot was commanded to stand."""
    result = run_trial(load_world(world), Settings().with_values({"planner.strategy": strategy, **values}), seed)
    measured = {"outcome": result.outcome, "time": result.arrival_time, "stood": result.maneuvers.get(STOPPED, 0)}
    return {"world": world, "strategy": strategy, "seed": seed, **measured}


def read(path: Path) -> dict[tuple[str, str, int], dict]:
    """The rows of a file, by world, strategy and seed."""
    return {(row["world"], row["strategy"], row["seed"]): row for row in JsonLines(path).records()}


def table(old: dict, new: dict) -> str:
    """A line for the pairs and one for the serpentines: arrivals, mean times, what changed, and who stood longer."""
    lines = [
        "| trials | reached, old and new | mean arrival, old and new [s] | longer [%] | stood longer |",
        "|---|---|---|---|---|",
    ]
    for name, cases in (("nine pairs", CASES[:300]), ("serpentines", SERPENTINES)):
        both = [(old[case], new[case]) for case in cases if case in old and case in new]
        reached = [sum(pair[side]["outcome"] == REACHED for pair in both) for side in (0, 1)]
        times = [[row["time"] for row in pair] for pair in both if all(row["outcome"] == REACHED for row in pair)]
        before, after = np.array(times).reshape(-1, 2).T
        longer = improvement(MEAN, [after], [before]).negated()
        interval = f"[{longer.low:+.2f}, {longer.high:+.2f}]" if longer.low is not None else longer.note
        cost = f"{longer.value or 0.0:+.2f} {interval}"
        stood = sum(pair[1]["stood"] > pair[0]["stood"] for pair in both)
        means = f"{before.mean():.3f}, {after.mean():.3f}" if times else ""
        lines.append(f"| {len(both)} {name} | {reached[0]}, {reached[1]} | {means} | {cost} | {stood} |")
    return "\n".join(lines)


def main(args: Sequence[str] | None = None) -> int:
    """Runs what is not there yet, or compares two files of rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, help="rows, one trial a line")
    parser.add_argument("--compare", type=Path, nargs=2, metavar=("OLD", "NEW"), help="rows of two states of the code")
    parser.add_argument("values", nargs="*", help="parameters, key=value, as lidar.sensor=low_cost")
    given = parser.parse_args(args)
    if given.compare:
        print(table(*map(read, given.compare)))
        return 0
    if not given.out:
        parser.error("expected --out or --compare")
    there, out = read(given.out), JsonLines(given.out)
    values = dict(value.split("=", 1) for value in given.values)
    for case in CASES:
        if case not in there:
            out.append(row_of(*case, values))
    return 0


if __name__ == "__main__":
    sys.exit(main())
