"""What is left of the gain of a bounce through the graph: runs in processes in real time beside trials without ROS.

    .venv/bin/python tools/graph_gain.py --out runs/graph_gain.jsonl              # on a machine that does nothing else
    .venv/bin/python tools/graph_gain.py --out runs/graph_gain.jsonl --worlds 0   # the tables of what is there

A trial and a run of bringup for each development world, seed and strategy, with equal parameters: the spread of the
rebound is that of the study of bounces. Rows are appended as they come, and one that is there is not run again; to run
one again, delete its line. Ctrl-C ends the graph in order, and the next call goes on. The folder of a run is deleted
once its figures are in its row, but for one that did not arrive. Prints tables for docs/results.md. Simulated.
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
from typing import Any

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings
from collplan_core.parameters.file import write_values
from collplan_core.replay.values import JournalError
from collplan_core.worlds import load_world
from collplan_ros.bringup.failures import GRAPH_LOST, NOT_REACHED
from collplan_ros.recording.recording_file import RECORDING
from collplan_ros.runs.result_files import SUMMARY
from collplan_ros.runs.run_error import RunError
from collplan_study.question.axes import parse_axes
from collplan_study.question.bounces import SPREADS
from graph_gain_report import FAMILIES, GRAPH, STRATEGIES, TRIAL, Case, case_of, report
from omnipuck_sim.trial import run_trial
from plan_delays import read_run_delays

FIRST_WORLD = 300
"""Seed of the first world of each family; these worlds may be tuned on."""
VALUES = {key: value for key, (value,) in parse_axes(SPREADS).items()}
"""Parameters that are not as shipped, the strategy aside."""
ENDED = (0, NOT_REACHED, GRAPH_LOST)
"""Exit codes of a bringup whose run has an outcome."""


def cases(worlds: int, seeds: int) -> Iterator[Case]:
    """All runs with so many worlds of each family and so many seeds; those compared follow one another."""
    for first, family, seed in product(range(FIRST_WORLD, FIRST_WORLD + worlds), FAMILIES, range(seeds)):
        for strategy, kind in product(STRATEGIES, (TRIAL, GRAPH)):
            yield Case(f"{family}:{first}", seed, strategy, kind)


def row_of(case: Case, folders: Path) -> dict[str, Any]:
    """A run: how it ended, when [s], and where the time went in the graph; its folder is made in `folders`."""
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
    parameters, said, run = folder / "spread.yaml", folder / "bringup.txt", folder / "latest"
    write_values(VALUES, parameters)
    given = ["--world", case.world, "--seed", str(case.seed), "--strategy", case.strategy, "--params", str(parameters)]
    program = [sys.executable, "-m", "collplan_ros.bringup.main", "--no-pictures", "--out", str(folder)]
    code = exit_code([*program, *given], said)
    if code not in ENDED or not (run / SUMMARY).exists():
        raise SystemExit(f"{case}: bringup ended with {code}: {said.read_text(errors='replace')[-2000:]}")
    summary = json.loads((run / SUMMARY).read_text())
    row = {"outcome": summary["outcome"], "time": summary["arrival_time_s"], **delays(run / RECORDING)}
    if row["outcome"] == REACHED and not row["unread"]:
        shutil.rmtree(folder)
    return row


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


def delays(recording: Path) -> dict[str, Any]:
    """Where the time went in the graph, as a row holds it; `unread` is why that cannot be told."""
    try:
        found = read_run_delays(recording)
    except (RunError, JournalError) as error:
        return {"unread": str(error)}
    return {
        "unread": "",
        "stages_ms": (1e3 * found.stages).round(3).tolist(),
        "doubt_ms": None if found.doubt is None else 1e3 * found.doubt,
        "plans": found.plans,
        "missed": found.missed,
        "lost": found.lost,
    }


def read(path: Path) -> list[dict[str, Any]]:
    """The rows of a file; none where it is not there."""
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def main(args: Sequence[str] | None = None) -> int:
    """Runs what is not there yet, and prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="rows, one run a line")
    parser.add_argument("--worlds", type=int, default=12, help="worlds of each family, seeds from 300 on (default 12)")
    parser.add_argument("--seeds", type=int, default=3, help="seeds of the noise in each world (default 3)")
    given = parser.parse_args(args)
    rows = read(given.out)
    there = {case_of(row) for row in rows}
    folders = given.out.with_name(f"{given.out.stem}_runs")
    given.out.parent.mkdir(parents=True, exist_ok=True)
    try:
        with given.out.open("a") as out:
            for case in cases(given.worlds, given.seeds):
                if case in there:
                    continue
                rows.append(row_of(case, folders))
                out.write(json.dumps(rows[-1]) + "\n")
                out.flush()
                print(f"{case}: {rows[-1]['outcome']}", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print("interrupted: the next call goes on", file=sys.stderr)
        return 130
    print(report(rows))
    return 0


if __name__ == "__main__":
    for stop in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(stop, signal.default_int_handler)
    sys.exit(main())
