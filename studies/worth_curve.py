"""What bounces save by N and restitution: the cells of the study, and what is between them."""

import json
from bisect import bisect_right
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from collplan_core.parameters import Settings
from collplan_study.analysis.statistics import Estimate

CURVE = Path(__file__).with_name("worth_curve.json")
FAMILIES = ("serpentine", "u", "baffles")


class Cell(NamedTuple):
    """Time that robots of one N and restitution save in one kind of corridor, with its interval [%]."""

    family: str
    number: float
    restitution: float
    saved: float
    low: float
    high: float


def number_of(settings: Settings) -> float:
    """N = v_max^2 / (a_max R): twice the braking distance, in radii."""
    robot = settings.robot
    return robot.max_speed**2 / (robot.max_acceleration * robot.radius)


def read_curve() -> list[Cell]:
    """The cells of the shipped curve."""
    return [Cell(**row) for row in json.loads(CURVE.read_text())]


def families_of(cells: Sequence[Cell]) -> list[str]:
    """Kinds of corridors in the order of FAMILIES."""
    return sorted({cell.family for cell in cells}, key=FAMILIES.index)


def expected(cells: Sequence[Cell], family: str, number: float, restitution: float) -> Estimate:
    """Time saved [%], linear in log N and in restitution between cells; a note names what lies outside of them."""
    columns: dict[float, list[Cell]] = {}
    for cell in sorted(cell for cell in cells if cell.family == family):
        columns.setdefault(cell.restitution, []).append(cell)
    known = sorted(columns)
    ends = [_along(columns[e], number) for e in known]
    value, low, high = (float(np.interp(restitution, known, each)) for each in zip(*ends, strict=True))
    # the columns that count are those on both sides of the restitution
    sides = [columns[e] for e in known[max(bisect_right(known, restitution) - 1, 0) :][:2]]
    notes = (
        _outside("N", number, max(side[0].number for side in sides), min(side[-1].number for side in sides)),
        _outside("restitution", restitution, known[0], known[-1]),
    )
    return Estimate(value, low, high, " and ".join(filter(None, notes)))


def _along(column: Sequence[Cell], number: float) -> tuple[float, ...]:
    """Time saved and its interval at an N, of cells in the order of theirs."""
    at, numbers = np.log(number), np.log([cell.number for cell in column])
    return tuple(float(np.interp(at, numbers, each)) for each in zip(*(cell[3:] for cell in column), strict=True))


def _outside(name: str, value: float, low: float, high: float) -> str:
    if low <= value <= high:
        return ""
    studied, used = f"{low:g} alone" if low == high else f"{low:g} to {high:g}", min(max(value, low), high)
    return f"{name} {value:.3g} lies outside of what was studied, {studied}: this is the figure at {used:g}"
