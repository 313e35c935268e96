"""Bench of the strategies among movers: trials with one to three movers, each beside the same without them.

    make movers ARGS="--trials 200 --seed 97000"
    make movers ARGS="--walks walks.csv"                recorded walks of people in place of drawn movers
    make movers ARGS="--lidar low_cost --trials 40"     trials without movers are those of the ideal LIDAR

Writes runs/movers.json and prints it as a table. Each trial goes to a file beside it as it ends; the next call goes on
there, with the same code. `movers_worlds` and `movers_walks` say which movers, `movers_rule` when no stop could have
saved a run.
Simulated.
"""

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings
from collplan_core.worlds.movers import DISC
from collplan_study.report.content import number
from collplan_study.run.pools import open_pool
from collplan_study.run.provenance import trial_code
from collplan_study.run.row_file import JsonLines
from markdown_text import Section, markdown
from movers_rule import STILL, share_in_view, speed_left
from movers_walks import crossing_of, read_walks
from movers_worlds import with_movers, world_of
from omnipuck_sim.trial import run_trial

STRATEGIES = ("avoid", "bounce", "low_risk")
JOBS = 2
ALONE, MOVERS, FORESEEN = "alone", "movers", "foreseen"
"""Without movers; with movers; with movers, and limits.emerging_speed at the speed of the fastest."""
COLUMNS = f"""Simulated. `touched_moving`: the robot drove towards what it touched, at above {STILL:g} m/s.
`appeared_too_close`: of these the runs in which no stop could have saved a touch; in the rest of them one could.
`time_over_no_movers`: sum of the arrival times over that of the same trials without movers."""
Task = tuple[int, int, str, str, str, str]
"""Number of the trial, first seed, strategy, which of the three, LIDAR, and the file of walks or none."""


def row_of(task: Task) -> dict[str, Any]:
    """The row of a trial: how it ended, when [s], and its touches of movers."""
    index, seed, strategy, kind, lidar, walks = task
    world = crossing_of(read_walks(Path(walks)), index, seed) if walks else world_of(index, seed)
    values: dict[str, Any] = {"planner.strategy": strategy, "lidar.sensor": lidar}
    if kind == ALONE:
        world = replace(world, movers=())
    elif not walks:
        world = with_movers(world, index, seed)
    if kind == FORESEEN:
        values["limits.emerging_speed"] = max(mover.speed for mover in world.movers)
    settings = Settings().with_values(values)
    result = run_trial(world, settings, seed + index)
    places, touches = result.trajectory[:, 1:3], []
    owners = np.repeat(np.arange(len(world.movers)), [1 if each.kind == DISC else 2 for each in world.movers])
    for (time, disc, speed), before in zip(result.touches, (-np.inf, *(t.time for t in result.touches)), strict=False):
        left = 0.0
        if speed > STILL:
            own = np.flatnonzero(owners == owners[disc])
            in_view = np.max([share_in_view(world, places, result.movers, each) for each in own], axis=0)
            touched = result.movers[:, disc].copy()
            touched[:, 2:4] = result.movers[:, own, 2:4].mean(axis=1)  # a person walks evenly, a leg does not
            left = speed_left(result.trajectory, touched, in_view, time, speed, settings.robot, before)
        touches.append({"time": time, "mover": int(owners[disc]), "speed": speed, "left": left})
    return {
        "task": task,
        "world": world.name,
        "outcome": result.outcome,
        "time": result.arrival_time,
        "touches": touches,
    }


def figures(strategy: str, rows: Sequence[dict[str, Any]], kind: str = MOVERS) -> dict[str, Any]:
    """A strategy's line of the file; in runs that `appeared_too_close`, a stop would have saved no touch in motion."""
    of_strategy = [row for row in rows if row["task"][2] == strategy]
    without = {row["task"][0]: row for row in of_strategy if row["task"][3] == ALONE}
    runs = [row for row in of_strategy if row["task"][3] == kind]
    moving = [[touch for touch in row["touches"] if touch["speed"] > STILL] for row in runs]
    pairs = [(row["time"], without[row["task"][0]]) for row in runs if row["task"][0] in without and reached(row)]
    times = [(time, other["time"]) for time, other in pairs if reached(other)]
    return {
        "strategy": strategy,
        "runs": len(runs),
        "reached": sum(map(reached, runs)),
        "touched": sum(bool(row["touches"]) for row in runs),
        "touched_moving": sum(map(bool, moving)),
        "fastest_towards_m_s": max((touch["speed"] for touches in moving for touch in touches), default=0.0),
        "appeared_too_close": sum(
            bool(touches) and all(touch["left"] > STILL for touch in touches) for touches in moving
        ),
        "time_over_no_movers": float(np.divide(*np.sum(times, axis=0))) if times else None,
    }


def reached(row: dict[str, Any]) -> bool:
    return bool(row["outcome"] == REACHED)


def table(lines: Sequence[dict[str, Any]]) -> str:
    """The lines as text."""
    rows = [tuple(number(v, 2) if isinstance(v, float) else str(v) for v in line.values()) for line in lines]
    return markdown(Section("", COLUMNS, tuple(lines[0]), rows))


def run_missing(tasks: Sequence[Task], out: JsonLines, code: str, jobs: int) -> Iterator[int]:
    """Runs tasks, few at a time, so that a run broken off keeps its rows; yields how many are done."""
    with open_pool(jobs, None) as (pool, _):
        for first in range(0, len(tasks), jobs):
            for k, future in enumerate([pool.submit(row_of, task) for task in tasks[first : first + jobs]], first):
                out.append({**future.result(), "code": code})
                yield k + 1


def main(args: Sequence[str] | None = None) -> int:
    """Runs what is not there yet, writes the file and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=200, help="trials of each strategy with movers (default 200)")
    parser.add_argument("--seed", type=int, default=97000, help="of the first world, its movers and noise")
    parser.add_argument("--walks", default="", metavar="FILE", help="recorded walks: walker, time [s], x, y [m]")
    parser.add_argument("--lidar", choices=("ideal", "low_cost"), default="ideal", help="LIDAR of trials with movers")
    parser.add_argument("--foreseen", action="store_true", help="limits.emerging_speed is that of the fastest mover")
    parser.add_argument("--jobs", type=int, default=JOBS, help=f"processes (default {JOBS})")
    parser.add_argument("--out", type=Path, default=Path("runs/movers.json"), help="the figures; rows go to .jsonl")
    given = parser.parse_args(args)
    try:
        if given.walks:
            read_walks(Path(given.walks))
    except (OSError, ValueError) as error:
        parser.error(f"--walks: {error}")
    kind = FORESEEN if given.foreseen else MOVERS
    out, code = JsonLines(given.out.with_suffix(".jsonl")), trial_code()
    wanted: list[Task] = [
        (index, given.seed, strategy, each, given.lidar if each == kind else "ideal", given.walks)
        for index, strategy, each in product(range(given.trials), STRATEGIES, (kind, ALONE))
    ]
    there = {tuple(row["task"]) for row in out.records() if row["code"] == code}
    missing = [task for task in wanted if task not in there]
    try:
        for done in run_missing(missing, out, code, given.jobs):
            if done % 20 == 0 or done == len(missing):
                print(f"{done} of {len(missing)}", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print("stopped; the next call goes on here", file=sys.stderr)
        return 130
    rows = [row for row in out.records() if row["code"] == code and tuple(row["task"]) in set(wanted)]
    lines = [figures(strategy, rows, kind) for strategy in STRATEGIES]
    given.out.write_text(json.dumps(lines, indent=1) + "\n", encoding="utf-8")
    print(table(lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())
