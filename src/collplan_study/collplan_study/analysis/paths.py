"""Paths of a study's runs, and the obstacle maps they are drawn on."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from collplan_core.worlds import World
from collplan_study.analysis.cases import Case
from collplan_study.analysis.rows import Rows

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

NO_IMPACTS = np.zeros((0, 2))


@dataclass(frozen=True, eq=False)
class RunPath:
    """Path of a run, to be drawn.

    Attributes:
        points: (n, 2) [m].
        outcome: outcome of the run.
        impacts: (k, 2) contact points of the impacts to be marked [m].
    """

    points: np.ndarray
    outcome: str
    impacts: np.ndarray


def read_paths(
    path: Path, case: Case, world: str, cell: Mapping[str, Any], impacts: Rows | None = None
) -> Iterator[RunPath]:
    """The paths of a cell's runs in a world, by trial.

    Args:
        path: path of trajectories.parquet.
        case: case that the cell belongs to.
        world: name of the world.
        cell: strategy and map_period_s.
        impacts: rows of the impacts to be marked; None marks none.
    """
    import pyarrow.parquet as pq

    chosen = {"family": case.family, "ablation": case.ablation, "world": world, **case.point, **cell}
    rows = pq.read_table(path, columns=["trial", "x", "y"], filters=[(k, "=", v) for k, v in chosen.items()])
    runs = case.runs.where(world=world, **cell)
    outcomes = dict(zip(runs.columns["trial"].tolist(), runs.columns["outcome"].tolist(), strict=True))
    for row in rows.to_pylist():
        points = NO_IMPACTS if impacts is None else _points(impacts.where(**chosen, trial=row["trial"]))
        yield RunPath(np.column_stack([row["x"], row["y"]]), outcomes[row["trial"]], points)


def _points(impacts: Rows) -> np.ndarray:
    return np.column_stack([impacts.columns["x"], impacts.columns["y"]])


def obstacles(world: World) -> "BaseGeometry":
    """The union of a world's obstacles."""
    from shapely import Point, Polygon, unary_union

    circles = [Point(x, y).buffer(radius, quad_segs=32) for x, y, radius in world.circles]
    return unary_union([*map(Polygon, world.polygons), *circles])


def grown_obstacles(world: World, radius: float) -> "BaseGeometry":
    """The augmented-obstacle map: where in the bounds the centre of a disc of `radius` [m] cannot be."""
    from shapely import box

    arena = box(*world.bounds)
    grown = obstacles(world).buffer(radius, quad_segs=32)
    if world.walled:
        grown = grown.union(arena.difference(arena.buffer(-radius)))
    return grown.intersection(arena)
