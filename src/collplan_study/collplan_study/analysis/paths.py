"""The paths of a study's runs, and the map they are drawn on."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from collplan_core.worlds import World
from collplan_study.analysis.runs import Case, Runs

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry


NO_IMPACTS = np.zeros((0, 2))


@dataclass(frozen=True, eq=False)
class Run:
    """A path (n, 2) [m], how the run ended, and the contact points (k, 2) [m] of those impacts that are to be shown."""

    points: np.ndarray
    outcome: str
    impacts: np.ndarray


def read_paths(
    path: Path, case: Case, world: str, cell: Mapping[str, Any], impacts: Runs | None = None
) -> Iterator[Run]:
    """The paths of a cell's runs in a world, out of trajectories.parquet, by trial; with their impacts if given."""
    import pyarrow.parquet as pq

    chosen = {"family": case.family, "ablation": case.ablation, "world": world, **case.point, **cell}
    rows = pq.read_table(path, columns=["trial", "x", "y"], filters=[(k, "=", v) for k, v in chosen.items()])
    runs = case.runs.where(world=world, **cell)
    outcomes = dict(zip(runs.columns["trial"].tolist(), runs.columns["outcome"].tolist(), strict=True))
    for row in rows.to_pylist():
        hits = NO_IMPACTS if impacts is None else _points(impacts.where(**chosen, trial=row["trial"]))
        yield Run(np.column_stack([row["x"], row["y"]]), outcomes[row["trial"]], hits)


def _points(impacts: Runs) -> np.ndarray:
    return np.column_stack([impacts.columns["x"], impacts.columns["y"]])


def obstacles(world: World) -> "BaseGeometry":
    """What is solid in a world."""
    from shapely import Point, Polygon, unary_union

    circles = [Point(x, y).buffer(radius, quad_segs=32) for x, y, radius in world.circles]
    return unary_union([*map(Polygon, world.polygons), *circles])


def grown_obstacles(world: World, radius: float) -> "BaseGeometry":
    """Where the centre of a disc of this radius [m] cannot be, within the bounds: the augmented-obstacle map."""
    from shapely import box

    arena = box(*world.bounds)
    grown = obstacles(world).buffer(radius, quad_segs=32)
    if world.walled:
        grown = grown.union(arena.difference(arena.buffer(-radius)))
    return grown.intersection(arena)
