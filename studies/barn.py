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
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl

from collplan_core.evaluation.run_end import REACHED
from collplan_core.worlds import World, WorldError, save_world
from collplan_study.analysis.results import VALUE, distinct, mean_over_worlds
from collplan_study.errors import StudyError
from collplan_study.question.specification import TIME
from collplan_study.report.content import with_interval
from collplan_study.run.study_folder import read_study
from markdown_text import Section, markdown
from sdf import load_sdf

START, GOAL = (-2.25, 3.0), (-2.25, 13.0)
"""Position of start and goal in every world [m]."""
SEEN = range(3, 238, 6)
"""Numbers of the 40 worlds by which `planner.shortest_frontier` was chosen: in-sample."""
OPTIMAL_SPEED = 2.0
"""Speed at which the optimal time takes the shortest path to be driven, the Jackal's [m/s]."""
CELL, FIRST_CELL = 0.15, (-4.575, 5.075)
"""Shipped paths are in cells of the grid that the cylinders stand on: size and first cell [m]."""
RULES = (
    "Score of a run: success x optimal time / clip(time, 2 x optimal time, 8 x optimal time), at most 0.5, where the "
    "optimal time is that of the data set's own shortest path at 2 m/s; then the mean over the worlds. In the "
    "challenge the first contact ends a run, as a failure. Here it does not; in the last column a run with a contact "
    "scores 0. Other differences: the robot is a disc that drives 1.2 m/s at most; time counts from the first command."
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
    # a run that raised has no time
    return optimal / min(max(time, 2.0 * optimal), 8.0 * optimal) if success else 0.0


def score_table(runs: pl.DataFrame, optimal: Mapping[str, float]) -> Section:
    """A row for each strategy, over the worlds in `optimal`, which holds their optimal times [s]."""
    head = ("strategy", "runs", "arrive", "time / optimal", "score", "untouched", "score, first touch ends the run")
    times = pl.DataFrame({"world": list(optimal), "optimal": list(optimal.values())})
    known = runs.join(times, on="world", maintain_order="left")
    rows = [_row(strategy, known.filter(strategy=strategy)) for strategy in distinct(known, "strategy")]
    return Section("BARN's score", RULES, head, rows)


def _row(strategy: str, runs: pl.DataFrame) -> tuple[str, ...]:
    arrived = runs.filter(outcome=REACHED)
    ratios = (arrived[TIME] / arrived["optimal"]).to_numpy()
    return (
        strategy,
        str(runs.height),
        str(arrived.height),
        f"{ratios.mean():.2f}" if len(ratios) else "none",
        _mean_score(runs, touching_fails=False),
        str(arrived.filter(impacts=0).height),
        _mean_score(runs, touching_fails=True),
    )


def _mean_score(runs: pl.DataFrame, touching_fails: bool) -> str:
    rows = runs.select("outcome", "impacts", TIME, "optimal").iter_rows()
    scores = [
        score(outcome == REACHED and not (touching_fails and impacts), time, optimal)
        for outcome, impacts, time, optimal in rows
    ]
    return with_interval(mean_over_worlds(runs.with_columns(pl.Series(VALUE, scores))), 3)


def _write_worlds(folder: Path, out: Path, scale: float, held_out: bool) -> str:
    found = {path: re.fullmatch(r"world_(\d+)\.world(\.gz)?", path.name) for path in sorted(folder.iterdir())}
    files = [path for path, name in found.items() if name and not (held_out and int(name[1]) in SEEN)]
    if not files:
        raise WorldError(f"{folder}: no worlds, expected files called world_N.world or world_N.world.gz")
    out.mkdir(parents=True, exist_ok=True)
    for path in files:
        save_world(barn_world(path, scale), out / f"{path.name.partition('.')[0]}.yaml")
    return f"{len(files)} worlds in {out}"


def _score(study: Path, folder: Path, scale: float) -> str:
    optimal = {name: scale * length / OPTIMAL_SPEED for name, length in optimal_lengths(folder).items()}
    return markdown(Section(note="All figures are simulated."), score_table(read_study(study).runs, optimal))


def main(args: Sequence[str] | None = None) -> int:
    """Converts the worlds, or prints the score of a study in them; exit code 2 where a file cannot be used."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    worlds, scored = commands.add_parser("worlds"), commands.add_parser("score")
    scored.add_argument("study", type=Path, help="folder of a study in these worlds")
    for each in (worlds, scored):
        each.add_argument("folder", type=Path, help="folder of the data set")
        each.add_argument("--scale", type=float, default=1.0, help="factor on all lengths (default 1)")
    worlds.add_argument("--held-out", action="store_true", help="leave out 3, 9, ... 237, by which a value was chosen")
    worlds.add_argument("--out", type=Path, required=True, help="folder of the world files")
    given = parser.parse_args(args)
    try:
        if given.command == "worlds":
            print(_write_worlds(given.folder, given.out, given.scale, given.held_out))
        else:
            print(_score(given.study, given.folder, given.scale))
    except (StudyError, WorldError, OSError, ValueError) as error:
        print(f"barn: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
