"""What is left of the gain of a bounce through the graph: runs in processes in real time beside trials without ROS.

    .venv/bin/python studies/graph_gain.py --out runs/graph_gain.jsonl             # on a machine that does nothing else
    .venv/bin/python studies/graph_gain.py --out runs/graph_gain.jsonl --worlds 0  # the table of what is there

A trial and a run of bringup for each development world, seed and strategy, with equal parameters: the spread of the
rebound is that of the study of bounces. Rows are appended as they come, and one that is there is not run again; to run
one again, delete its line. Ctrl-C ends the graph in order, and the next call goes on. The folder of a run is deleted
once its figures are in its row, but for one that did not arrive. Prints a table for docs/results.md. Simulated.
"""

import argparse
import json
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings
from collplan_core.parameters.file import write_values
from collplan_core.worlds import load_world
from collplan_ros.bringup.failures import GRAPH_LOST, NOT_REACHED
from collplan_study.analysis.statistics import MEAN, Estimate, level_of, share_of
from collplan_study.question.axes import parse_axes
from collplan_study.question.bounces import SPREADS
from collplan_study.report.content import Section, number, with_interval
from collplan_study.report.markdown import markdown_table
from collplan_study.run.json_lines import JsonLines
from omnipuck_sim.trial import run_trial

FAMILIES = ("serpentine", "u")
STRATEGIES = OURS, AGAINST = ("bounce", "avoid")
TRIAL, GRAPH = "trial", "graph"
KINDS = tuple(product((TRIAL, GRAPH), STRATEGIES))
"""The four runs of a world and a seed, which are compared with one another."""
FIRST_WORLD = 300
"""Seed of the first world of each family; these worlds may be tuned on."""
VALUES = {key: value for key, (value,) in parse_axes(SPREADS).items()}
"""Parameters that are not as shipped, the strategy aside."""
ENDED = (0, NOT_REACHED, GRAPH_LOST)
"""Exit codes of a bringup whose run has an outcome."""


class Case(NamedTuple):
    """A run: where, with which seed of the noise, how, and whether it is a TRIAL or goes through the GRAPH."""

    world: str
    seed: int
    strategy: str
    kind: str

    def __str__(self) -> str:
        return f"{self.world} {self.strategy} seed {self.seed}, {self.kind}"


def case_of(row: dict[str, Any]) -> Case:
    """Which run a row is of."""
    return Case(*(row[key] for key in Case._fields))


def cases(worlds: int, seeds: int) -> Iterator[Case]:
    """All runs with so many worlds of each family and so many seeds; those compared follow one another."""
    for first, family, seed in product(range(FIRST_WORLD, FIRST_WORLD + worlds), FAMILIES, range(seeds)):
        for kind, strategy in KINDS:
            yield Case(f"{family}:{first}", seed, strategy, kind)


def row_of(case: Case, folders: Path) -> dict[str, Any]:
    """A run: how it ended, and when [s]; its folder is made in `folders`."""
    folder = folders / f"{case.world.replace(':', '_')}_{case.seed}_{case.strategy}"
    return {**case._asdict(), **(trial(case) if case.kind == TRIAL else through_graph(case, folder))}


def trial(case: Case) -> dict[str, Any]:
    """The run without ROS."""
    settings = Settings().with_values({**VALUES, "planner.strategy": case.strategy})
    result = run_trial(load_world(case.world), settings, case.seed)
    return {"outcome": result.outcome, "time": result.arrival_time}


def through_graph(case: Case, folder: Path) -> dict[str, Any]:
    """The run in processes, in real time."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    parameters, said, summary = folder / "spread.yaml", folder / "bringup.txt", folder / "latest" / "summary.json"
    write_values(VALUES, parameters)
    given = ["--world", case.world, "--seed", str(case.seed), "--strategy", case.strategy, "--params", str(parameters)]
    program = [sys.executable, "-m", "collplan_ros.bringup.main", "--no-pictures", "--out", str(folder)]
    code = exit_code([*program, *given], said)
    if code not in ENDED or not summary.exists():
        raise SystemExit(f"{case}: bringup ended with {code}: {said.read_text(errors='replace')[-2000:]}")
    found = json.loads(summary.read_text())
    if found["outcome"] == REACHED:
        shutil.rmtree(folder)
    return {"outcome": found["outcome"], "time": found["arrival_time_s"]}


def exit_code(command: Sequence[str], output: Path) -> int:
    """Runs a program to its end, its output in a file; Ctrl-C asks it to end, and it is waited for all the same."""
    with output.open("wb") as file:
        # in a session of its own: Ctrl-C comes to it once, from here
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=file, stderr=subprocess.STDOUT, start_new_session=True
        )
    try:
        return process.wait()
    except KeyboardInterrupt:
        process.send_signal(signal.SIGINT)
        process.wait()
        raise


def gain_table(rows: Sequence[dict[str, Any]]) -> Section:
    """A row a family: arrivals, mean times and gains, over the worlds and seeds with which all four runs arrived."""
    times = (f"{strategy}, {kind} [s]" for kind, strategy in KINDS)
    return Section(
        "The gain in trials and through the graph",
        f"A gain is 100 (1 - {OURS} / {AGAINST}) of two arrival times, in the mean over the worlds; left is the gain "
        "in the graph over that in trials; 95 % intervals by resampling the worlds.",
        ("worlds", "reached, trial and graph", "compared", *times, "gain, trial [%]", "gain, graph [%]", "left [%]"),
        [(family, *_cells([row for row in rows if row["world"].startswith(family)])) for family in FAMILIES]
        + [("all", *_cells(rows))],
    )


def _cells(rows: Sequence[dict[str, Any]]) -> list[str]:
    by_kind = [[row["outcome"] == REACHED for row in rows if row["kind"] == kind] for kind in (TRIAL, GRAPH)]
    times = _times(rows)
    # over the worlds, as gains are
    means = np.mean([each.mean(axis=0) for each in times], axis=0).tolist() if times else [None] * len(KINDS)
    in_trials, in_graph = ([100.0 * (1.0 - each[:, k] / each[:, k + 1]) for each in times] for k in (0, 2))
    whole = level_of(MEAN, in_trials)
    above_zero = whole.low is not None and whole.low > 0.0
    left = share_of(in_graph, in_trials) if above_zero else Estimate(None, note="no gain that is surely above zero")
    return [
        ", ".join(f"{sum(each)} of {len(each)}" for each in by_kind),
        f"{sum(map(len, times))} in {len(times)} worlds",
        *(number(mean, 2) for mean in means),
        *(with_interval(each, 1) for each in (whole, level_of(MEAN, in_graph))),
        with_interval(left, 0),
    ]


def _times(rows: Sequence[dict[str, Any]]) -> list[np.ndarray]:
    """(n, 4) arrival times [s] in each world, in the order of KINDS, with the n seeds with which all four arrived."""
    reached = {case_of(row): row["time"] for row in rows if row["outcome"] == REACHED}
    found: dict[str, list[list[float]]] = {}
    for world, seed in dict.fromkeys((row["world"], row["seed"]) for row in rows):
        four = [Case(world, seed, strategy, kind) for kind, strategy in KINDS]
        if all(case in reached for case in four):
            found.setdefault(world, []).append([reached[case] for case in four])
    return [np.array(each) for each in found.values()]


def main(args: Sequence[str] | None = None) -> int:
    """Runs what is not there yet, and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="rows, one run a line")
    parser.add_argument("--worlds", type=int, default=12, help="worlds of each family, seeds from 300 on (default 12)")
    parser.add_argument("--seeds", type=int, default=3, help="seeds of the noise in each world (default 3)")
    given = parser.parse_args(args)
    out = JsonLines(given.out)
    there = {case_of(row) for row in out.records()}
    folders = given.out.with_name(f"{given.out.stem}_runs")
    try:
        for case in (case for case in cases(given.worlds, given.seeds) if case not in there):
            row = row_of(case, folders)
            out.append(row)
            print(f"{case}: {row['outcome']}", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print("interrupted: the next call goes on", file=sys.stderr)
        return 130
    rows = out.records()
    print("\n".join(markdown_table(gain_table(rows))))
    print("\n".join(f"{case_of(row)}: {row['outcome']}" for row in rows if row["outcome"] != REACHED))
    return 0


if __name__ == "__main__":
    for stop in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(stop, signal.default_int_handler)
    sys.exit(main())
