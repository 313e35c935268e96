"""What is left of the gain of a bounce through the graph: runs of bringup beside trials without ROS.

    make graph-gain                        # 12 worlds of each family, 2 runs each, in one process
    make graph-gain ARGS="--real-time"     # in processes and real time, on a machine that does nothing else
    make graph-gain ARGS="--worlds 2 --seeds 1"

A trial and a run of bringup for each world, seed and strategy, with equal parameters: the spread of the rebound is that
of the study of bounces. Rows are appended as they come, and one that is there is not run again; to run it again, delete
its line. Ctrl-C ends the graph in order, and the next call goes on. The folder of a run is deleted once its figures are
in its row, but for one that did not arrive. Writes graph_gain.json beside the rows, and prints two tables. Simulated.
"""

import argparse
import json
import math
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from itertools import pairwise, product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings
from collplan_core.parameters.file import write_values
from collplan_core.replay.journal import CONTROLLER, PLANNER
from collplan_core.replay.reading import Call, Event
from collplan_core.worlds import load_world
from collplan_ros.bringup.ending import GRAPH_LOST, NOT_REACHED
from collplan_ros.replay.recorded_journals import read_journals
from collplan_study.analysis.statistics import MEAN, Estimate, improvement, level_of
from collplan_study.question.question import parse_axes
from collplan_study.question.specification import SPREADS
from collplan_study.report.content import number, with_interval
from collplan_study.run.row_file import JsonLines
from markdown_text import Section, markdown
from omnipuck_sim.trial import run_trial

FAMILIES = ("serpentine", "u")
STRATEGIES = OURS, AGAINST = ("bounce", "avoid")
TRIAL, GRAPH = "trial", "graph"
KINDS = tuple(product((TRIAL, GRAPH), STRATEGIES))
"""The four runs of a world and a seed, which are compared with one another."""
FIRST_WORLD = 8100
"""Seed of the first world of each family; nothing was tuned on these."""
STAGES = (
    "stamp of a pose, until planner_node takes it",
    "until it begins the plan",
    "until controller_node takes the plan",
    "until the control period begins whose command follows it",
)
"""What each begins with, the one before ends with."""
MISSED = 1.5
"""A control period longer than so many of its own was missed."""
VALUES = {key: value for key, (value,) in parse_axes(SPREADS).items()}
"""Parameters that are not as shipped, the strategy aside."""
ENDED = (0, NOT_REACHED, GRAPH_LOST)
"""Exit codes of a bringup whose run has an outcome."""


class Case(NamedTuple):
    """A run: where, with which seed of the noise, how, whether it is a TRIAL or through the GRAPH, and its pace."""

    world: str
    seed: int
    strategy: str
    kind: str
    one_process: bool

    def __str__(self) -> str:
        return f"{self.world} {self.strategy} seed {self.seed}, {self.kind}"


def case_of(row: dict[str, Any]) -> Case:
    """Which run a row is of."""
    return Case(*(row[key] for key in Case._fields))


def cases(worlds: int, seeds: int, one_process: bool) -> Iterator[Case]:
    """All runs with so many worlds of each family and so many seeds; those compared follow one another."""
    for first, family, seed in product(range(FIRST_WORLD, FIRST_WORLD + worlds), FAMILIES, range(seeds)):
        for kind, strategy in KINDS:
            yield Case(f"{family}:{first}", seed, strategy, kind, one_process)


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
    """The run of bringup."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    parameters, said, summary = folder / "spread.yaml", folder / "bringup.txt", folder / "latest" / "summary.json"
    write_values(VALUES, parameters)
    given = ["--world", case.world, "--seed", str(case.seed), "--strategy", case.strategy, "--params", str(parameters)]
    program = [sys.executable, "-m", "collplan_ros.bringup.main", "--no-pictures", "--out", str(folder)]
    code = exit_code([*program, *given, *([] if case.one_process else ["--processes"])], said)
    if code not in ENDED or not summary.exists():
        raise SystemExit(f"{case}: bringup ended with {code}: {said.read_text(errors='replace')[-2000:]}")
    found = json.loads(summary.read_text())
    journals = read_journals(folder / "latest")
    stages, missed = delays(journals.events(PLANNER), journals.events(CONTROLLER))
    if found["outcome"] == REACHED:
        shutil.rmtree(folder)
    timed = {"stages_ms": (1e3 * stages).round(2).tolist(), "missed_ticks": missed}
    return {"outcome": found["outcome"], "time": found["arrival_time_s"], **timed}


def delays(planner: Sequence[Event], controller: Sequence[Event]) -> tuple[np.ndarray, int]:
    """What each of STAGES took of each plan that a command followed (n, 4) [s], and the control periods missed.

    A node's clock counts from another moment than stamps do. How much is between them is taken from the pose that was
    quickest, so that its own way is left out.
    """
    planned, begun, zero = _planned(planner)
    rows, ticks, taken, here = [], list[float](), dict[float, float](), math.inf
    for call in (event for event in controller if isinstance(event, Call)):
        if call.name == "take_pose":
            here = min(here, call.args[1] - call.args[0].stamp)
        elif call.name == "take_plan":
            taken[call.args[0].stamp] = call.args[-1]
        elif call.name == "tick":
            ticks.append(call.args[0])
            rows += [(stamp, at, call.args[0]) for stamp, at in taken.items()]
            taken.clear()
    found = [
        (planned[stamp] - stamp - zero, begun[stamp] - planned[stamp], at - here - begun[stamp] + zero, tick - at)
        for stamp, at, tick in rows
        if stamp in planned and stamp in begun
    ]
    longest = MISSED / Settings().controller.rate
    return np.array(found).reshape(-1, len(STAGES)), sum(after - before > longest for before, after in pairwise(ticks))


def _planned(planner: Sequence[Event]) -> tuple[dict[float, float], dict[float, float], float]:
    """When planner_node took each pose, when it began each plan, by stamp, and its clock where stamps are 0 [s]."""
    taken, begun = dict[float, float](), dict[float, float]()
    for call in (event for event in planner if isinstance(event, Call)):
        if call.name == "take_pose":
            taken[call.args[0].stamp] = call.args[1]
        for plan in (each["plan"] for each in call.result or () if isinstance(each, dict) and "plan" in each):
            begun[plan["stamp"]] = call.args[-1]
    return taken, begun, min((at - stamp for stamp, at in taken.items()), default=math.inf)


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
    in_trials, in_graph, left = gains(rows)
    return [
        ", ".join(f"{sum(each)} of {len(each)}" for each in by_kind),
        f"{sum(map(len, times))} in {len(times)} worlds",
        *(number(mean, 2) for mean in means),
        *(with_interval(each, 1) for each in (in_trials, in_graph)),
        with_interval(left, 0),
    ]


def gains(rows: Sequence[dict[str, Any]]) -> tuple[Estimate, Estimate, Estimate]:
    """The gain in trials and in the graph, and the share of the first that is the second [%]."""
    in_trials, in_graph = ([100.0 * (1.0 - each[:, k] / each[:, k + 1]) for each in _times(rows)] for k in (0, 2))
    whole = level_of(MEAN, in_trials)
    above_zero = whole.low is not None and whole.low > 0.0
    lost = improvement(MEAN, in_graph, in_trials)
    value, low, high = (None if each is None else 100.0 - each for each in (lost.value, lost.high, lost.low))
    none = Estimate(None, note="no gain that is surely above zero")
    return whole, level_of(MEAN, in_graph), Estimate(value, low, high, lost.note) if above_zero else none


def stage_table(rows: Sequence[dict[str, Any]]) -> Section:
    """Where each millisecond goes from the stamp of a pose to the command of a plan from it."""
    found = {strategy: _stages(rows, strategy) for strategy in STRATEGIES}
    columns = [np.column_stack([each, each.sum(axis=1)]).T for each in found.values()]
    names = (*STAGES, "in all")
    return Section(
        "From a pose to a command",
        "Of each plan that a command followed; the quickest pose is taken to come at once.",
        ("", *(f"{strategy}, {part} [ms]" for strategy in STRATEGIES for part in ("median", "p99"))),
        [
            (name, *(number(each, 1) for column in columns for each in _middle_and_end(column[k])))
            for k, name in enumerate(names)
        ],
    )


def _stages(rows: Sequence[dict[str, Any]], strategy: str) -> np.ndarray:
    found = [row["stages_ms"] for row in rows if row["kind"] == GRAPH and row["strategy"] == strategy]
    return np.array([stage for each in found for stage in each]).reshape(-1, len(STAGES))


def _middle_and_end(values: np.ndarray) -> tuple[float | None, float | None]:
    """Median and 99th percentile; None without a value."""
    return (float(np.median(values)), float(np.quantile(values, 0.99))) if len(values) else (None, None)


def results(rows: Sequence[dict[str, Any]], one_process: bool) -> dict[str, Any]:
    """What graph_gain.json holds: gains and share [%], delays [ms]."""
    in_trials, in_graph, left = gains(rows)
    graph = [row for row in rows if row["kind"] == GRAPH]
    delay = {
        s: dict(zip(("median", "p99"), _middle_and_end(_stages(rows, s).sum(axis=1)), strict=True)) for s in STRATEGIES
    }
    return {
        "gain_trials": in_trials.value,
        "gain_graph": in_graph.value,
        "share": None if left.value is None else left.value / 100.0,
        "share_low": None if left.low is None else left.low / 100.0,
        "share_high": None if left.high is None else left.high / 100.0,
        "pose_to_command_ms": delay,
        "missed_ticks": sum(row["missed_ticks"] for row in graph),
        "runs": len(graph),
        "reached": sum(row["outcome"] == REACHED for row in graph),
        "one_process": one_process,
    }


def _times(rows: Sequence[dict[str, Any]]) -> list[np.ndarray]:
    """(n, 4) arrival times [s] in each world, in the order of KINDS, with the n seeds with which all four arrived."""
    reached = {case_of(row): row["time"] for row in rows if row["outcome"] == REACHED}
    found: dict[str, list[list[float]]] = {}
    for world, seed, one_process in dict.fromkeys((row["world"], row["seed"], row["one_process"]) for row in rows):
        four = [Case(world, seed, strategy, kind, one_process) for kind, strategy in KINDS]
        if all(case in reached for case in four):
            found.setdefault(world, []).append([reached[case] for case in four])
    return [np.array(each) for each in found.values()]


def main(args: Sequence[str] | None = None) -> int:
    """Runs what is not there yet, and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("runs/graph_gain.jsonl"), help="rows, one run a line")
    parser.add_argument("--worlds", type=int, default=12, help="worlds of each family (default 12)")
    parser.add_argument("--seeds", type=int, default=2, help="seeds of the noise in each world (default 2)")
    parser.add_argument("--real-time", action="store_true", help="simulated time does not wait for nodes that are late")
    given = parser.parse_args(args)
    out, one_process = JsonLines(given.out), not given.real_time
    there = {case_of(row) for row in out.records()}
    folders = given.out.with_name(f"{given.out.stem}_runs")
    wanted = list(cases(given.worlds, given.seeds, one_process))
    try:
        for number_of, case in enumerate(wanted, start=1):
            if case not in there:
                row = row_of(case, folders)
                out.append(row)
                print(f"{number_of} of {len(wanted)}: {case}: {row['outcome']}", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print("interrupted: the next call goes on", file=sys.stderr)
        return 130
    rows = [row for row in out.records() if case_of(row) in set(wanted)]
    found = given.out.with_suffix(".json")
    found.write_text(json.dumps(results(rows, one_process), indent=2) + "\n")
    print(markdown(gain_table(rows), stage_table(rows)))
    print("\n".join(f"{case_of(row)}: {row['outcome']}" for row in rows if row["outcome"] != REACHED))
    print(f"written to {found}")
    return 0


if __name__ == "__main__":
    for stop in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(stop, signal.default_int_handler)
    sys.exit(main())
