"""What `bounce` saves against `avoid` by N = v_max^2 / (a_max R) and restitution, the curve behind `make worth`.

    make worth-study                       # runs what is missing, one or two hours on one core
    make worth-study ARGS="--no-run"       # the curve and the tables of the runs there are

Rows are appended as they come, and one that is there is not run again. Simulated.
"""

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from collplan_core.evaluation.run_end import REACHED
from collplan_study.analysis.statistics import MEAN, Estimate, level_of
from collplan_study.report.content import number, with_interval
from collplan_study.run.row_file import JsonLines
from markdown_text import Section, markdown
from worth_curve import CURVE, FAMILIES, Cell, expected, read_curve
from worth_runs import AGAINST, DRAWN, OURS, SEEDS, TURNING, Robot, row_of, run_of, runs

Saved = dict[Robot, dict[str, list[float]]]
"""Returns by robot and family the time that bounce saves in each world where both arrive [%]."""


def saved_by(rows: Sequence[dict[str, Any]]) -> Saved:
    """What the rows say."""
    times = {run_of(row): row["time"] for row in rows if row["outcome"] == REACHED}
    found: Saved = {}
    for run, time in times.items():
        against = times.get(run._replace(strategy=AGAINST))
        if run.strategy == OURS and against is not None:
            found.setdefault(run.robot, {}).setdefault(run.family, []).append(100.0 * (1.0 - time / against))
    return found


def mean_of(savings: Sequence[float]) -> Estimate:
    """The mean over worlds."""
    return level_of(MEAN, [np.array([each]) for each in savings])


def curve_of(saved: Saved) -> Iterator[Cell]:
    """Cells of the robots that differ from the shipped one in N and restitution alone, with all worlds."""
    for robot, families in saved.items():
        if robot == Robot(robot.number, robot.restitution):
            for family, each in families.items():
                mean = mean_of(each)
                if (
                    len(each) == len(SEEDS)
                    and mean.value is not None
                    and mean.low is not None
                    and mean.high is not None
                ):
                    yield Cell(family, robot.number, robot.restitution, mean.value, mean.low, mean.high)


def table(saved: Saved) -> Section:
    """A row a robot."""
    rows = []
    for robot in sorted(saved, key=lambda each: each[::-1]):
        families = saved[robot]
        together = [each for family in TURNING for each in families.get(family, [])]
        groups = (*(families.get(family, []) for family in FAMILIES), together)
        name = (f"{robot.radius:g}, {robot.speed:g}, {robot.engine}", f"{robot.restitution:g}", f"{robot.number:g}")
        rows.append((*name, *(f"{with_interval(mean_of(each), 1)} ({len(each)})" if each else "" for each in groups)))
    head = ("R [m], v_max [m/s], engine", "restitution", "N", *FAMILIES, "serpentine and u")
    note = "Mean and 95 % interval; in brackets the worlds in which both arrive."
    return Section("Time that bounce saves against avoid [%]", note, head, rows)


def predictions(saved: Saved) -> Section:
    """A row for each robot that was drawn after the curve: its prediction and what was measured."""
    cells, rows = read_curve(), []
    for robot in DRAWN:
        drawn_values = (robot.radius, robot.speed, robot.settings(OURS).robot.max_acceleration, robot.restitution)
        row = [number(each, 2) for each in drawn_values] + [number(robot.number, 1)]
        for family in TURNING:
            row.append(with_interval(expected(cells, family, robot.number, robot.restitution), 1))
            row.append(with_interval(mean_of(saved.get(robot, {}).get(family, [])), 1))
        rows.append(tuple(row))
    head = ("R [m]", "v_max [m/s]", "a_max [m/s^2]", "restitution", "N")
    told = tuple(f"{family}, {which}" for family in TURNING for which in ("predicted", "measured"))
    return Section("Robots drawn afterwards, time saved [%]", "", head + told, rows)


def main(args: Sequence[str] | None = None) -> int:
    """Runs what is not there yet, and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("runs/worth.jsonl"), help="rows, one run a line")
    parser.add_argument("--no-run", action="store_true", help="tables of the runs there are")
    parser.add_argument("--curve", action="store_true", help="write the curve that make worth reads")
    given = parser.parse_args(args)
    out = JsonLines(given.out)
    there = {run_of(row) for row in out.records()}
    missing = [] if given.no_run else [run for run in runs() if run not in there]
    for number_of, run in enumerate(missing, start=1):
        row = row_of(run)
        out.append(row)
        print(f"{number_of} of {len(missing)}: {run}: {row['outcome']}", file=sys.stderr, flush=True)
    rows = out.records()
    saved = saved_by(rows)
    if given.curve:
        CURVE.write_text("[\n" + ",\n".join(json.dumps(cell._asdict()) for cell in curve_of(saved)) + "\n]\n")
    measured = {robot: families for robot, families in saved.items() if robot not in DRAWN}
    print(markdown(table(measured), predictions(saved)))
    print(f"{len(rows)} runs, {sum(row['outcome'] == REACHED for row in rows)} arrived")
    return 0


if __name__ == "__main__":
    sys.exit(main())
