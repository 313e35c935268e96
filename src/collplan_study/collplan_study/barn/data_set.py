"""BARN, a data set of 300 cluttered worlds for navigation: its files, the rules and the score of its challenge.

Perille, Truong, Xiao, Stone: Benchmarking Metric Ground Navigation (2020); rules and score as in the code of the BARN
challenge. Its robot is a Jackal, 0.51 m by 0.43 m, at 2 m/s. Unscaled, the worlds are
wide for a smaller robot; scaled by its diameter over the Jackal's width they are as narrow for it as for a Jackal.
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
"""Position of start and goal in every world [m]."""
TOLERANCE = 1.0
"""Distance to the goal that counts as arrived [m]."""
TIMEOUT = 100.0
"""Time limit of a run [s]."""

OPTIMAL_SPEED = 2.0
"""Speed at which the optimal time takes the shortest path to be driven, the Jackal's [m/s]."""

LENGTHS_FILE = "path_length_m.json"
PATHS_FOLDER = "path_files"

# shipped paths are in cells of the grid that the cylinders stand on: size and first cell [m], from the data set's code
_CELL = 0.15
_FIRST_CELL = (-4.575, 5.075)


def barn_files(folder: Path) -> dict[int, Path]:
    """Files world_N.world and world_N.world.gz of a folder by their number N, ascending.

    Raises:
        WorldError: the folder does not exist, holds no world, or holds one twice.
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
    """A world of the data set, named barn:N, with the start and goal of the challenge.

    Args:
        path: world_N.world or world_N.world.gz.
        scale: factor on all coordinates and sizes.

    Raises:
        WorldError: the file cannot be used, as in `load_sdf`.
    """
    world = load_sdf(path, np.array(START), np.array(GOAL), scale)
    return replace(world, name=world.name.replace("world_", "barn:"))


def barn_rules(scale: float = 1.0) -> dict[str, float]:
    """Parameters that the challenge sets, by key: goal tolerance [m] in a world scaled by `scale`, time limit [s]."""
    return {"planner.goal_tolerance": scale * TOLERANCE, "trial.timeout": TIMEOUT}


def optimal_lengths(folder: Path, scale: float = 1.0) -> dict[str, float]:
    """Length of the data set's shortest path from start to goal [m], by the world's name.

    Taken from path_length_m.json, else from the paths that the data set ships; worlds without either are left out.

    Raises:
        WorldError: one of these files cannot be read.
    """
    lengths = _read_lengths(folder / LENGTHS_FILE) if (folder / LENGTHS_FILE).is_file() else _lengths_of_paths(folder)
    return {f"barn:{n}": scale * lengths[n] for n in barn_files(folder) if n in lengths}


def optimal_time(length: float) -> float:
    """Time [s] in which the challenge's robot drives a shortest path of this length [m] at OPTIMAL_SPEED."""
    return length / OPTIMAL_SPEED


def score(success: bool, time: float, optimal: float) -> float:
    """Score of one run, 0 to 0.5, as the challenge publishes it.

    Args:
        success: whether the run arrived.
        time: duration of the run [s].
        optimal: `optimal_time` of the world [s].
    """
    return success * optimal / min(max(time, 2.0 * optimal), 8.0 * optimal)


def _read_lengths(path: Path) -> dict[int, float]:
    form = 'expected {"N": length of the path [m], ...}'
    try:
        lengths = {int(n): float(length) for n, length in json.loads(path.read_bytes()).items()}
    except (OSError, ValueError, TypeError, AttributeError):
        raise WorldError(f"{path}: cannot be read, {form}") from None
    for n, length in lengths.items():
        if not (isfinite(length) and length > 0.0):
            raise WorldError(f"{path}: {n}: got {length:g}, {form}")
    return lengths


def _lengths_of_paths(folder: Path) -> dict[int, float]:
    paths = {n: folder / PATHS_FOLDER / f"path_{n}.npy" for n in barn_files(folder)}
    return {n: _path_length(path) for n, path in paths.items() if path.is_file()}


def _path_length(path: Path) -> float:
    try:
        cells = np.load(path, allow_pickle=False).astype(float)
        points = np.vstack([START, cells * _CELL + _FIRST_CELL, GOAL])
    except (OSError, ValueError, EOFError):
        raise WorldError(f"{path}: cannot be read, expected cells (n, 2) of a path") from None
    return float(np.hypot(*np.diff(points, axis=0).T).sum())
