"""The result files of a run: trajectory, impacts, summary and picture."""

import csv
import json
import math
import textwrap
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import closing
from itertools import compress
from pathlib import Path
from typing import Any

import numpy as np

from collplan_core.evaluation.run_end import OUTCOMES, REACHED, Timing, machine_verdict
from collplan_core.evaluation.run_record import RunRecord
from collplan_core.parameters import Settings, all_specs
from collplan_ros.messages.reading import movers_from_markers
from collplan_ros.messages.status_values import DRIVE
from collplan_ros.run.reader import messages
from collplan_ros.run.record import counted_impacts, write_impacts
from collplan_ros.run.recorded_run import SUMMARY, RecordedRun, read_run
from collplan_ros.run.run_log import PoseRow, RunLog
from collplan_ros.run.whole_file import FolderLock, RecordError, RunError, has_end, replacing
from collplan_ros.run.writer import RECORDING


def timing_of(log: RunLog, record: RunRecord) -> Timing:
    """Timing of a run, from its first command to move to its end; no gap where simulated time waits for the nodes.

    The gap is the longest time between two commands, which their sender's middleware stamps.
    """
    begin = record.begin
    poses = [pose for pose in log.poses if begin is not None and pose.stamp >= begin]
    simulated_time = poses[-1].stamp - poses[0].stamp if poses else 0.0
    passed = poses[-1].sent - poses[0].sent if poses else 0.0
    factor = simulated_time / passed if log.simulated and passed > 0.0 else None
    gaps = np.diff(record.sent[record.driven]) if log.pace else np.zeros(0)
    return Timing(factor, float(gaps.max(initial=0.0)))


COLUMNS = ("t", "x", "y", "yaw", "vx", "vy", "cmd_vx", "cmd_vy", "cmd_wz", "ref_x", "ref_y", "maneuver")
UNKNOWN = math.nan


def write_trajectory(path: Path, log: RunLog) -> None:
    """Writes one row per pose: pose and velocity in the world frame, last command in the robot's frame, tracked point.

    t counts from the first non-zero command, so arrival_time_s is the last t of a run that reached its goal and lost no
    pose. Commands, points and maneuvers hold from the time they were sent, not received; the rows are therefore written
    after the run.
    """
    begin = log.begin
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for pose in log.poses:
            numbers = (pose.stamp - begin, *pose[1:6], *_commanded(pose, log))
            writer.writerow([*(f"{number:.6f}" for number in numbers), log.maneuver_at(pose.sent)])


def _commanded(pose: PoseRow, log: RunLog) -> tuple[float, ...]:
    command, reference = log.command_at(pose.sent), log.reference_at(pose.sent)
    return (*(command[1:] if command else (UNKNOWN,) * 3), *(reference[1:] if reference else (UNKNOWN,) * 2))


CHOSEN = ("simulator.world", "simulator.seed")
"""Parameters of the simulator that are no assumptions about the robot."""


def summarize(log: RunLog, record: RunRecord, outcome: str, goal: np.ndarray, settings: Settings) -> dict[str, Any]:
    """The figures of a run, ready for JSON.

    They cover the time from the first non-zero command to the end of the log; a run that reached its goal ends with the
    first pose within goal_tolerance. The rebound error is the median over the impacts that the last plan before each
    foresaw. Impacts with movers are known of simulated robots alone. Impacts and plans above limits.impact_speed are
    counted by the speed into the obstacle. Maneuvers are counted in control periods. The control period and the time of
    the first command come from the controller's middleware, which stamps its messages, so that the load of bringup does
    not affect them. Where simulated time waits for the nodes, the control period is one of simulated time.
    """
    verdicts, driven, limit = record.verdicts, record.driven, settings.limits.impact_speed
    given = record.sent if log.pace else record.commands[:, 0]
    source = "ground_truth" if record.is_true else "mocap poses, low-passed at 5 Hz, resampled at 20 Hz"
    return {
        "outcome": outcome,
        "reached": outcome == REACHED,
        "arrival_time_s": record.elapsed if outcome == REACHED and record.begin is not None else None,
        "path_length_m": record.path_length,
        "path_length_source": source,
        "impacts": len(record.impacts),
        "impacts_foreseen": int(verdicts.foreseen.sum()),
        "impacts_deliberate": int(verdicts.deliberate.sum()),
        "impacts_with_movers": sum(each.with_mover for each in record.impacts),
        "impacts_above_impact_speed": int((record.speeds > limit).sum()),
        "hardest_impact_m_s": float(record.speeds.max(initial=0.0)),
        "plans_above_impact_speed": int((log.figure("hardest_contact") > limit).sum()),
        "rebound_direction_error_deg": _told(np.median, np.degrees(verdicts.rebounds[:, 0])),
        "goal": [float(value) for value in goal],
        "strategy": settings.planner.strategy,
        "plan_time_ms": _percentiles(record.planning_times),
        "control_period_ms": _percentiles(1e3 * np.diff(given[driven])),
        "candidates": {
            "mean": _told(np.mean, record.candidates),
            "before_pruning_mean": _told(np.mean, record.candidates_before_pruning),
        },
        "maneuvers": dict(Counter(compress(record.commanded, driven))),
    }


def assumed_constants(settings: Settings, simulated: bool) -> dict[str, Any]:
    """Values, by key, of all parameters documented as assumed, and of the simulator where the robot is simulated."""
    values = settings.values()

    def is_assumed(key: str, doc: str) -> bool:
        if key.startswith("simulator."):
            return simulated and key not in CHOSEN
        return "(assumed)" in doc

    return {key: values[key] for key, spec in all_specs().items() if is_assumed(key, spec.doc)}


def _percentiles(values: np.ndarray) -> dict[str, Any]:
    if len(values) == 0:
        return {"p50": None, "p99": None, "n": 0}
    p50, p99 = np.percentile(values, [50, 99])
    return {"p50": float(p50), "p99": float(p99), "n": len(values)}


def _told(statistic: Callable[[np.ndarray], Any], values: np.ndarray) -> float | None:
    """A statistic of the finite values; None where there are none."""
    known = values[np.isfinite(values)]
    return float(statistic(known)) if len(known) else None


TRAJECTORY, IMPACTS, PICTURE = "trajectory.csv", "impacts.csv", "trajectory.png"


def _rebounds(record: RunRecord, settings: Settings) -> str:
    """The restitution that impacts show, in words, for who writes the parameter file; nothing learns it."""
    found, told = record.restitutions, settings.rebound.restitution
    hits = counted_impacts(len(found))
    return f"; {hits} with restitution {np.median(found):.2f}, set to {told:g}" if found else ""


def _learnt_lines(drive: Mapping[str, float]) -> list[str]:
    """Lines of a parameter file that set what was learnt."""
    return [f"robot.{name}: {drive[name]:.4g}" for name in DRIVE if f"{name}.learnt" in drive]


def write_result_files(run: RecordedRun, goal: np.ndarray, outcome: str, said: Mapping[str, Any]) -> dict[str, Any]:
    """Writes trajectory, impacts and summary of a run, each of them whole, the trajectory first; returns the summary.

    The goal is (2,) [m]; `said` are further values of the summary. RecordError: a file cannot be written.
    """
    folder, log, settings = run.folder, run.log, run.settings
    with replacing(folder / TRAJECTORY) as path:
        write_trajectory(path, log)
    record = run.record
    with replacing(folder / IMPACTS) as path:
        write_impacts(path, record, log.begin)
    timing, words = timing_of(log, record), log.drive_in_words + _rebounds(record, settings)
    summary = {
        "simulated": log.simulated,
        "world": settings.simulator.world,
        "seed": settings.simulator.seed,
        **summarize(log, record, outcome, goal, settings),
        "real_time_factor": timing.factor,
        "longest_gap_s": timing.gap,
        "machine": machine_verdict(timing, settings.simulator.speed_factor, settings.limits.command_age),
        **said,
        **({"drive": {**log.drive, "in_words": words, "parameters": _learnt_lines(log.drive)}} if log.drive else {}),
        "assumed": assumed_constants(settings, log.simulated),
    }
    with replacing(folder / SUMMARY) as path:
        path.write_text(json.dumps(summary, indent=2, allow_nan=False) + "\n")
    return summary


# ---- the picture


AROUND = 0.8
"""Shown of a world without an end beside the robot's way [m]."""
MOVERS = "ground_truth/movers"
SHOWN = 0.5
"""Time between two places of a mover that are drawn [s]."""


def draw_trajectory(path: Path, run: RecordedRun, goal: np.ndarray) -> None:
    """Writes a picture of world, way coloured by speed, impacts and goal (2,) [m], from a run with its result files."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Circle, Polygon

    way, hits = (
        np.atleast_1d(np.genfromtxt(run.folder / name, delimiter=",", names=True)) for name in (TRAJECTORY, IMPACTS)
    )
    figure = Figure(figsize=(7.0, 7.0), layout="constrained")
    FigureCanvasAgg(figure)
    # a world's name may hold what matplotlib takes for formulas
    figure.suptitle("\n".join(textwrap.wrap(f"{run.title}: {run.end.words}", 80)), fontsize=10, parse_math=False)
    axes = figure.add_subplot(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    world = run.world
    for corners in world.polygons:
        axes.add_patch(Polygon(corners, facecolor="#c9d1db", edgecolor="#46566b"))
    for x, y, radius in world.circles:
        axes.add_patch(Circle((x, y), radius, facecolor="#c9d1db", edgecolor="#46566b"))
    speeds = axes.scatter(way["x"], way["y"], c=np.hypot(way["vx"], way["vy"]), s=5, cmap="plasma", vmin=0.0)
    figure.colorbar(speeds, label="speed [m/s]", shrink=0.85)
    for number, rows in enumerate(mover_places(run.recording, run.settings.frames.map)):
        for x, y, radius in rows:
            axes.add_patch(Circle((x, y), radius, facecolor="none", edgecolor="#7a4fa3", linewidth=0.6))
        label = f"movers, every {SHOWN:g} s" if number == 0 else None
        axes.plot(*rows[:, :2].T, color="#7a4fa3", linewidth=0.8, label=label)
    axes.plot(hits["x"], hits["y"], "D", color="#d55e00", markeredgecolor="white", linestyle="none", label="impacts")
    axes.plot(*goal, "*", color="#00855f", markersize=11, linestyle="none", label="goal")
    figure.legend(loc="outside lower center", ncols=2, frameon=False)
    places = np.vstack([np.column_stack([way["x"], way["y"]]), goal])
    ends = np.vstack([places.min(axis=0) - AROUND, places.max(axis=0) + AROUND])
    x0, y0, x1, y1 = world.bounds if np.isfinite(world.bounds).all() and world.walled else ends.ravel()
    axes.set(xlim=(x0, x1), ylim=(y0, y1))
    figure.savefig(path, dpi=150)


def mover_places(recording: Path, frame: str) -> list[np.ndarray]:
    """(m, 3) x, y, radius [m] of each true mover of a simulated run, every SHOWN; empty without recording or movers."""
    places: list[np.ndarray] = []
    due = -np.inf
    for _, _, message in messages(recording, [MOVERS]) if recording.exists() else ():
        stamp, rows = movers_from_markers(message, frame)
        if stamp >= due:
            due = stamp + SHOWN
            places.append(rows[:, [0, 1, 4]])
    return list(np.swapaxes(np.array(places), 0, 1)) if places else []


# ---- a run whose bringup was killed


KILLED, WHY_KILLED = "killed", "bringup ended before the run did"
"""Outcome of a run whose bringup did not live to see another, and its reason."""
UNTOLD, WHY_UNTOLD = "ended", f"{RECORDING} does not hold why"
"""Outcome of a run that ended without a report of its goal's end, and its reason."""


def complete(folder: Path) -> str:
    """Makes the results that a killed bringup has not left in a run folder; returns a sentence about that, or ""."""
    if has_end(folder / SUMMARY) or not (folder / RECORDING).exists():
        return ""
    try:
        with closing(FolderLock(folder)):
            run = read_run(folder)
            if not np.isfinite(run.log.goal).all():
                return ""
            ends = [OUTCOMES[each.name] for each in run.log.statuses if each.name in OUTCOMES]
            outcome, why = (UNTOLD, WHY_UNTOLD) if run.has_ended or run.lacks else (KILLED, WHY_KILLED)
            if ends and outcome == UNTOLD:
                outcome, why = ends[-1], ""
            write_result_files(run, run.log.goal, outcome, {"reason": why})
    except BlockingIOError:
        return f"{folder}: is being written, and is left unchanged"
    except (OSError, RecordError, RunError) as error:
        return f"{folder / SUMMARY} is not made: {error}"
    return f"{folder / SUMMARY} and the other results are made from {RECORDING}"
