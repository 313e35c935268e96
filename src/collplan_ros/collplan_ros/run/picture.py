"""trajectory.png: the robot's way through the world, from the result files of a run."""

import textwrap
from pathlib import Path

import numpy as np

from collplan_ros.messages.mover_reading import movers_from_markers
from collplan_ros.run.reader import messages
from collplan_ros.run.recorded_run import RecordedRun
from collplan_ros.run.result_files import IMPACTS, TRAJECTORY

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
