"""Worlds of recorded walks: a robot crosses an open floor on which people walk as they were filmed.

A file of walks is a table with a first line: walker, time [s], x, y [m], a few places a second. Nobody in it knew of a
robot. Its way leads through the place where one of them is about when the robot gets there, to a goal that stays free.
"""

import csv
from pathlib import Path

import numpy as np

from collplan_core.worlds import Mover, World
from collplan_core.worlds.movers import PERSON

HALF = 2.0
"""Half of the robot's way [m]."""
COMES = 2.5
"""Time after which the robot is expected in the middle of it [s]."""
LASTS, AROUND = 30.0, 5.0
"""Time of the walks that is taken [s], and how near to the middle they come [m]."""
FREE = 0.7
"""Distance that everybody keeps from the start until the robot has left, and from the goal when it may arrive [m]."""
LEAVES, ARRIVES = 1.5, 3.0
"""[s]"""
SLOWEST = 0.5
"""Speed of one whose way is crossed [m/s]."""
DRAWS = 1000
"""Draws of a walk after which the file is taken to hold none that a robot can cross."""
LEGS = (0.05, 0.07)
"""Radius of a leg [m]."""


def read_walks(path: Path) -> list[np.ndarray]:
    """The walks (n, 3) time [s], x, y [m] of a file, by time; a ValueError names it and the line that is no place."""
    with Path(path).open(encoding="utf-8", newline="") as lines:
        rows = list(csv.reader(lines))[1:]
    table = np.array([_place(f"{path}: line {i}", row) for i, row in enumerate(rows, 2)]).reshape(-1, 4)
    walks = []
    for walker in np.unique(table[:, 0]):
        walk = table[table[:, 0] == walker, 1:]
        walk = walk[np.argsort(walk[:, 0])]
        again = walk[1:, 0][np.diff(walk[:, 0]) <= 0.0]
        if len(again):
            raise ValueError(f"{path}: got walker {walker:g} twice at {again[0]:g} s, expected one place at a time")
        if len(walk) > 1:
            walks.append(walk)
    if not walks:
        raise ValueError(f"{path}: got no walk, expected two places or more of a walker")
    return walks


def _place(key: str, row: list[str]) -> list[float]:
    try:
        place = [float(value) for value in row]
    except ValueError:
        place = []
    if len(place) != 4 or not np.isfinite(place).all():
        raise ValueError(f"{key}: got {','.join(row)!r:.80}, expected walker, time [s], x, y [m]")
    return place


def crossing_of(walks: list[np.ndarray], index: int, seed: int) -> World:
    """The world of a trial: start, goal and all who walk there, drawn until both ends are free; ValueError: never."""
    random = np.random.default_rng([seed, index, 3])
    for _ in range(DRAWS):
        walk = walks[random.integers(len(walks))]
        k, angle = int(random.integers(1, len(walk))), random.uniform(-np.pi, np.pi)
        begins = walk[k, 0] - COMES + random.uniform(-0.5, 0.5)
        half = HALF * np.array([np.cos(angle), np.sin(angle)])
        start, goal = walk[k, 1:] - half, walk[k, 1:] + half
        if np.hypot(*(walk[k, 1:] - walk[k - 1, 1:])) < SLOWEST * (walk[k, 0] - walk[k - 1, 0]):
            continue
        there = [_from(each, begins) for each in walks if begins - 1.0 < each[-1, 0] and each[0, 0] < begins + LASTS]
        there = [each for each in there if np.hypot(*(each[:, 1:] - walk[k, 1:]).T).min() < AROUND]
        if all(_leaves_free(each, start, goal) for each in there):
            corners = np.vstack([start, goal, *(each[:, 1:] for each in there)])
            low, high = corners.min(axis=0) - 1.0, corners.max(axis=0) + 1.0
            movers = tuple(_person(each, random) for each in there)
            bounds = tuple(np.concatenate([low, high]).tolist())
            return World(f"walks:{seed + index}", (), np.zeros((0, 3)), bounds, False, start, goal, movers=movers)
    raise ValueError(f"walks: got none at {SLOWEST} m/s or more with a free start and goal in {DRAWS} draws")


def _from(walk: np.ndarray, begins: float) -> np.ndarray:
    """A walk by the time from `begins` on; who comes later, or leaves, walks straight on outside the record."""
    times = walk[:, 0] - begins
    first = walk[0, 1:] - (walk[1, 1:] - walk[0, 1:]) / (times[1] - times[0]) * times[0]
    if times[0] <= 0.0:
        first = np.array([np.interp(0.0, times, walk[:, i]) for i in (1, 2)])
    last = walk[-1, 1:] + (walk[-1, 1:] - walk[-2, 1:]) / (times[-1] - times[-2]) * LASTS
    inner = times > 1e-6
    return np.vstack(
        [[0.0, *first], np.column_stack([times, walk[:, 1:]])[inner], [max(times[-1], 0.0) + LASTS, *last]]
    )


def _leaves_free(walk: np.ndarray, start: np.ndarray, goal: np.ndarray) -> bool:
    times = np.arange(0.0, LASTS, 0.1)
    places = np.column_stack([np.interp(times, walk[:, 0], walk[:, i]) for i in (1, 2)])
    near_start = np.hypot(*(places - start).T) < FREE
    near_goal = np.hypot(*(places - goal).T) < FREE
    return not (near_start[times < LEAVES].any() or near_goal[times > ARRIVES].any())


def _person(walk: np.ndarray, random: np.random.Generator) -> Mover:
    length, lasts = np.hypot(*np.diff(walk[:, 1:], axis=0).T).sum(), walk[-1, 0] - walk[0, 0]
    speed = max(float(length / lasts), 0.2) if lasts > 0.0 else SLOWEST
    return Mover(random.uniform(*LEGS), walk[:, 1:], speed, kind=PERSON, times=walk[:, 0])
