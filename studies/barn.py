"""BARN, a data set of 300 cluttered worlds for navigation: its worlds as world files, and the score of its challenge.

    .venv/bin/python studies/barn.py worlds DIR --out runs/barn           # the data set's world_N.world as world files
    .venv/bin/study --worlds runs/barn --map-periods 0.2 --trials 5 --out runs/barn_study \\
        --set planner.goal_tolerance=1 --set trial.timeout=100            # the challenge's rules
    .venv/bin/python studies/barn.py score runs/barn_study DIR            # a table in Markdown

Perille, Truong, Xiao, Stone: Benchmarking Metric Ground Navigation (2020); rules and score as in the code of the BARN
challenge. Its robot is a Jackal, 0.51 m by 0.43 m, at 2 m/s. Unscaled, the worlds are wide for a smaller robot; with
`--scale` 0.42, this robot's diameter over the Jackal's width, they are as narrow for it as for a Jackal, and the
tolerance of 1 m is 0.42 m then.
"""

import argparse
import json
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from collplan_core.evaluation.run_end import REACHED
from collplan_core.worlds import World, WorldError, save_world
from collplan_study.analysis.comparisons import TIME
from collplan_study.analysis.rows import Rows, sample_of
from collplan_study.analysis.statistics import MEAN, level_of
from collplan_study.errors import StudyError
from collplan_study.report.content import Table, with_interval
from collplan_study.report.markdown import markdown_table
from collplan_study.report.study_data import read_study
from sdf import load_sdf

START, GOAL = (-2.25, 3.0), (-2.25, 13.0)
"""Position of start and goal in every world [m]."""
OPTIMAL_SPEED = 2.0
"""Speed at which the optimal time takes the shortest path to be driven, the Jackal's [m/s]."""
CELL, FIRST_CELL = 0.15, (-4.575, 5.075)
"""Shipped paths are in cells of the grid that the cylinders stand on: size and first cell [m]."""
RULES = (
    "Score of a run: success x optimal time / clip(time, 2 x optimal time, 8 x optimal time), at most 0.5, where the "
    "optimal time is that of the data set's own shortest path at 2 m/s; then the mean over the worlds. Not the "
    "challenge's rules: a contact does not end a run here, so runs without any are counted beside; the robot is a disc "
    "that drives 1.2 m/s at most; time counts from the first command."
)


def barn_world(path: Path, scale: float = 1.0) -> World:
    """The world in a file world_N.world or world_N.world.gz, named barn:N, with start and goal of the challenge."""
    world = load_sdf(path, START, GOAL, scale)
    return replace(world, name=world.name.replace("world_", "barn:"))


def optimal_lengths(folder: Path) -> dict[str, float]:
    """Length of the data set's shortest path from start to goal [m], by the world's name, before scaling.

    Taken from path_length_m.json, {"N": length}, else from path_files/path_N.npy; worlds without either are left out.
    """
    listed = folder / "path_length_m.json"
    if listed.is_file():
        return {f"barn:{n}": float(length) for n, length in json.loads(listed.read_bytes()).items()}
    paths = {path.stem.replace("path_", "barn:"): np.load(path) for path in folder.glob("path_files/path_*.npy")}
    ways = {name: np.vstack([START, cells * CELL + FIRST_CELL, GOAL]) for name, cells in paths.items()}
    return {name: float(np.hypot(*np.diff(points, axis=0).T).sum()) for name, points in ways.items()}


def score(success: bool, time: float, optimal: float) -> float:
    """Score of one run, 0 to 0.5, by its duration and the world's optimal time [s]."""
    return success * optimal / min(max(time, 2.0 * optimal), 8.0 * optimal)


def score_table(runs: Rows, optimal: Mapping[str, float]) -> Table:
    """A row for each strategy, over the worlds in `optimal`, which holds their optimal times [s]."""
    head = ("strategy", "runs", "arrive", "time / optimal", "score", "untouched", "score of untouched runs")
    return Table("BARN's score", RULES, head, [_row(runs, each, optimal) for each in runs.distinct("strategy")])


def _row(runs: Rows, strategy: str, optimal: Mapping[str, float]) -> tuple[str, ...]:
    rows = [row for row in runs.where(strategy=strategy).dicts() if row["world"] in optimal]
    arrived = [row for row in rows if row["outcome"] == REACHED]
    untouched = [row for row in arrived if not row["impacts"]]
    ratios = [row[TIME] / optimal[row["world"]] for row in arrived]
    return (
        strategy,
        str(len(rows)),
        str(len(arrived)),
        f"{np.mean(ratios):.2f}" if ratios else "none",
        _mean_score(rows, arrived, optimal),
        str(len(untouched)),
        _mean_score(rows, untouched, optimal),
    )


def _mean_score(rows: Sequence[dict], successes: Sequence[dict], optimal: Mapping[str, float]) -> str:
    succeeded = {(row["world"], row["trial"]): row[TIME] for row in successes}
    scores: dict[str, dict[int, float]] = {}
    for world, trial in ((row["world"], row["trial"]) for row in rows):
        time = succeeded.get((world, trial))
        found = 0.0 if time is None else score(True, time, optimal[world])
        scores.setdefault(world, {})[trial] = found
    return with_interval(level_of(MEAN, sample_of(scores)), 3)


def _write_worlds(folder: Path, out: Path, scale: float) -> Iterator[str]:
    files = sorted(path for path in folder.iterdir() if re.fullmatch(r"world_\d+\.world(\.gz)?", path.name))
    if not files:
        raise WorldError(f"{folder}: no worlds, expected files called world_N.world or world_N.world.gz")
    out.mkdir(parents=True, exist_ok=True)
    for path in files:
        save_world(barn_world(path, scale), out / f"{path.name.partition('.')[0]}.yaml")
    yield f"{len(files)} worlds in {out}"


def _score(study: Path, folder: Path, scale: float) -> Iterator[str]:
    optimal = {name: scale * length / OPTIMAL_SPEED for name, length in optimal_lengths(folder).items()}
    yield from ("All figures are simulated.", "", *markdown_table(score_table(read_study(study).runs, optimal)))


def main(args: Sequence[str] | None = None) -> int:
    """Converts the worlds, or prints the score of a study in them; exit code 2 where a file cannot be used."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    worlds, scored = commands.add_parser("worlds"), commands.add_parser("score")
    scored.add_argument("study", type=Path, help="folder of a study in these worlds")
    for each in (worlds, scored):
        each.add_argument("folder", type=Path, help="folder of the data set")
        each.add_argument("--scale", type=float, default=1.0, help="factor on all lengths (default 1)")
    worlds.add_argument("--out", type=Path, required=True, help="folder of the world files")
    given = parser.parse_args(args)
    try:
        if given.command == "worlds":
            print("\n".join(_write_worlds(given.folder, given.out, given.scale)))
        else:
            print("\n".join(_score(given.study, given.folder, given.scale)))
    except (StudyError, WorldError, OSError, ValueError) as error:
        print(f"barn: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
