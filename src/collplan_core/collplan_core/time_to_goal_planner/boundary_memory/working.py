"""Working data while a scan is merged, as plain tuples that compiled code takes."""

from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.record import LocalMap
from collplan_core.movers.record import STANDS
from collplan_core.time_to_goal_planner.boundary_memory.clearance import INFERRED, OBSERVED, Grid
from collplan_core.time_to_goal_planner.boundary_memory.record import RememberedBoundaries


class Pool(NamedTuple):
    """The remembered pieces as in the record, with room for new ones, and the fate of each; written to.

    Attributes:
        kinds: OBSERVED where it stands, PENDING where it does not but the newest scan shows it, else INFERRED.
        kept: whether a piece stays remembered.
        fresh: whether the newest scan shows a piece.
    """

    pieces: np.ndarray
    normals: np.ndarray
    solid_behind: np.ndarray
    seen_free_behind: np.ndarray
    seen: np.ndarray
    times_contradicted: np.ndarray
    kinds: np.ndarray
    kept: np.ndarray
    fresh: np.ndarray


class Cuts(NamedTuple):
    """Boundaries that the newest scan shows, cut into pieces.

    Attributes:
        pieces: (m, 4) x0, y0, x1, y1 [m].
        normals: (m, 2) unit normals toward the robot.
        inner: (m,) whether they are far enough from both ends of what was seen of their surface to infer solid.
    """

    pieces: np.ndarray
    normals: np.ndarray
    inner: np.ndarray


class Sight(NamedTuple):
    """The newest scan as beams from a place.

    Attributes:
        ranges: (b,) how far each beam saw [m].
        x, y: origin of the beams [m]; first: bearing of the first; step: angle between two [rad].
        beams: (b, 3) where each begins [m] and how much farther it is turned [rad]; (0, 3) where all do at x, y.
        half_side: half the side of the square in which it counts [m].
        stamp: stamp of the scan [s].
        stands: (b,) whether what each beam met has stood in place.
        swept: (m, 3) discs x, y, radius in which movers were lately [m].
    """

    ranges: np.ndarray
    x: float
    y: float
    first: float
    step: float
    beams: np.ndarray
    half_side: float
    stamp: float
    stands: np.ndarray
    swept: np.ndarray


class Nodes(NamedTuple):
    """The clearance field while it is renewed; written to.

    Attributes:
        clearance, source: (nx, ny) as in the field; free: (nx, ny) as in the record.
        stale: (nx, ny) whether the clearance has to be computed anew.
        grid: grid of the nodes.
        radius: radius of the disc [m].
    """

    clearance: np.ndarray
    source: np.ndarray
    free: np.ndarray
    stale: np.ndarray
    grid: Grid
    radius: float


def pool_of(memory: RememberedBoundaries, more: int) -> Pool:
    """A copy of the remembered pieces with room for some more."""

    def longer(array: np.ndarray) -> np.ndarray:
        return np.concatenate([array, np.zeros((more, *array.shape[1:]), array.dtype)])

    n = len(memory.pieces) + more
    return Pool(
        longer(memory.pieces),
        longer(memory.normals),
        longer(memory.solid_behind),
        longer(memory.seen_free_behind),
        longer(memory.seen),
        longer(memory.times_contradicted),
        longer(np.where(memory.kinds == OBSERVED, OBSERVED, INFERRED)),
        np.arange(n) < len(memory.pieces),
        np.zeros(n, bool),
    )


def sight_of(local_map: LocalMap) -> Sight:
    """The scan that a local map was built from."""
    x, y, first, step = (float(value) for value in local_map.view_from)
    ranges, kinds = local_map.view, local_map.returns.kinds
    stands = kinds == STANDS if len(kinds) else np.ones(len(ranges), bool)
    place = x, y, first, step, local_map.view_beams, local_map.half_side
    return Sight(ranges, *place, local_map.stamp, stands, local_map.returns.swept)


@njit
def middle(piece: np.ndarray) -> tuple[float, float]:
    """The point halfway along a piece [m]."""
    return 0.5 * (piece[0] + piece[2]), 0.5 * (piece[1] + piece[3])
