"""BARN, 300 cluttered worlds that others made for another robot: its files, its rules and its published score.

Perille, Truong, Xiao, Stone: Benchmarking Metric Ground Navigation (2020); rules and score as in the code of the BARN
challenge. Its robot is a Jackal, 0.51 m by 0.43 m, at 2 m/s. As they are, the worlds are wide for a smaller robot;
scaled by its diameter over the Jackal's width they are as narrow for it as for a Jackal, and shorter too.
"""

import json
import re
from dataclasses import replace
from math import isfinite
from pathlib import Path

import numpy as np

from collplan_core.worlds import World, WorldError
from collplan_study.barn.sdf import load_sdf

START, GOAL = (-2.25, 3.0), (-2.25, 13.0)
TOLERANCE = 1.0
"""Distance to the goal that counts as arrived [m]."""
TIMEOUT = 100.0
"""[s]"""

OPTIMAL_SPEED = 2.0
"""Speed that the shortest path is thought to be driven at; that of the Jackal [m/s]."""

LENGTHS_FILE = "path_length_m.json"
PATHS_FOLDER = "path_files"

# the shipped paths count cells of the grid that the cylinders stand on; where its first cell lies, from their code
_CELL = 0.15
_FIRST_CELL = (-4.575, 5.075)


def barn_files(folder: Path) -> dict[int, Path]:
    """The worlds in a folder, world_N.world or world_N.world.gz, by their number, in its order.

    Raises:
        WorldError: no such folder, none in it, or one of them twice.
    """
    if not folder.is_dir():
        raise WorldError(f"barn:{folder}: no such folder")
    files: dict[int, Path] = {}
    for path in sorted(folder.iterdir()):
        match = re.fullmatch(r"world_(\d+)\.world(\.gz)?", path.name)
        if match:
            other = files.setdefault(int(match[1]), path)
            if other != path:
                raise WorldError(f"{path}: the same world as {other.name}, expected each once")
    if not files:
        raise WorldError(f"barn:{folder}: no worlds, expected files called world_N.world or world_N.world.gz")
    return dict(sorted(files.items()))


def load_barn(path: Path, scale: float = 1.0) -> World:
    """A world of the data set from its start to its goal, all of it `scale` times as large; called barn:N.

    Raises:
        WorldError: as `load_sdf`.
    """
    world = load_sdf(path, np.array(START), np.array(GOAL), scale)
    return replace(world, name=world.name.replace("world_", "barn:"))


def barn_rules(scale: float = 1.0) -> dict[str, float]:
    """Parameters by key that the benchmark sets: when a run has arrived and when it is over."""
    return {"planner.goal_tolerance": scale * TOLERANCE, "trial.timeout": TIMEOUT}


def optimal_lengths(folder: Path, scale: float = 1.0) -> dict[str, float]:
    """Length [m] of the data set's own shortest path, from start to goal, by the world's name.

    Found in path_length_m.json, else in the paths that the data set ships; worlds without either are left out.

    Raises:
        WorldError: such a file does not hold what it should.
    """
    lengths = _listed(folder / LENGTHS_FILE) if (folder / LENGTHS_FILE).is_file() else _measured(folder)
    return {f"barn:{n}": scale * lengths[n] for n in barn_files(folder) if n in lengths}


def optimal_time(length: float) -> float:
    """Of a shortest path's length [m], in [s]."""
    return length / OPTIMAL_SPEED


def score(success: bool, time: float, optimal: float) -> float:
    """Of one run, its time and the optimal one [s]: 0 to 0.5, as the challenge publishes it."""
    return success * optimal / min(max(time, 2.0 * optimal), 8.0 * optimal)


def _listed(path: Path) -> dict[int, float]:
    form = 'expected {"N": length of the path [m], ...}'
    try:
        lengths = {int(n): float(length) for n, length in json.loads(path.read_bytes()).items()}
    except (OSError, ValueError, TypeError, AttributeError):
        raise WorldError(f"{path}: cannot be read, {form}") from None
    for n, length in lengths.items():
        if not (isfinite(length) and length > 0.0):
            raise WorldError(f"{path}: {n}: got {length:g}, {form}")
    return lengths


def _measured(folder: Path) -> dict[int, float]:
    paths = {n: folder / PATHS_FOLDER / f"path_{n}.npy" for n in barn_files(folder)}
    return {n: _path_length(path) for n, path in paths.items() if path.is_file()}


def _path_length(path: Path) -> float:
    try:
        cells = np.load(path, allow_pickle=False).astype(float)
        points = np.vstack([START, cells * _CELL + _FIRST_CELL, GOAL])
    except (OSError, ValueError, EOFError):
        raise WorldError(f"{path}: cannot be read, expected cells (n, 2) of a path") from None
    return float(np.hypot(*np.diff(points, axis=0).T).sum())
