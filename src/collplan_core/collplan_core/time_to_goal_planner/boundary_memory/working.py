"""Working data while a scan is merged, as plain tuples that compiled code takes."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.record import LocalMap
from collplan_core.movers.record import STANDS
from collplan_core.time_to_goal_planner.boundary_memory.clearance import INFERRED, OBSERVED, ClearanceField, Grid


@dataclass(frozen=True, eq=False)
class RememberedBoundaries:
    """Memory of the boundaries around the robot, world frame.

    The obstacle of the disc's centre is the union of the discs around the pieces and around the solid inferred behind
    some of them.
    """

    pieces: np.ndarray  # (k, 4) short straight pieces x0, y0, x1, y1 of the boundaries themselves, not grown [m]
    normals: np.ndarray  # (k, 2) unit normals toward where they were seen from
    solid_behind: np.ndarray  # (k,) whether solid is inferred behind them
    seen: np.ndarray  # (k,) stamp of the last scan that showed them [s]
    free: np.ndarray  # (nx, ny) on the field's nodes: whether the disc's centre was seen to be free there
    field: ClearanceField  # clearance of the disc's centre from all of it
    seen_free_behind: np.ndarray  # (k,) whether what could be inferred behind them was seen to be free
    times_contradicted: np.ndarray  # (k,) int8, number of scans running that saw through them
    kinds: np.ndarray
    """(k,) OBSERVED where they have stood for movers.standing_time, else PENDING in sight, INFERRED out of it."""


class Pool(NamedTuple):
    """The remembered pieces as in the record, with room for new ones, and the fate of each; written to."""

    pieces: np.ndarray
    normals: np.ndarray
    solid_behind: np.ndarray
    seen_free_behind: np.ndarray
    seen: np.ndarray
    times_contradicted: np.ndarray
    kinds: np.ndarray  # OBSERVED where it stands, PENDING where it does not but the newest scan shows it, else INFERRED
    kept: np.ndarray  # whether a piece stays remembered
    fresh: np.ndarray  # whether the newest scan shows a piece


class Cuts(NamedTuple):
    """Boundaries that the newest scan shows, cut into pieces."""

    pieces: np.ndarray  # (m, 4) x0, y0, x1, y1 [m]
    normals: np.ndarray  # (m, 2) unit normals toward the robot
    inner: np.ndarray
    """(m,) whether they are far enough from both ends of what was seen of their surface to infer solid."""


class Sight(NamedTuple):
    """The newest scan as beams from a place."""

    ranges: np.ndarray  # (b,) how far each beam saw [m]
    x: float  # x, y: origin of the beams [m]
    y: float
    first: float  # bearing of the first beam [rad]
    step: float  # angle between two beams [rad]
    beams: np.ndarray
    """(b, 3) where each begins [m] and how much farther it is turned [rad]; (0, 3) where all do at x, y."""
    half_side: float  # half the side of the square in which it counts [m]
    stamp: float  # stamp of the scan [s]
    stands: np.ndarray  # (b,) whether what each beam met has stood in place
    swept: np.ndarray  # (m, 3) discs x, y, radius in which movers were lately [m]


class Nodes(NamedTuple):
    """The clearance field while it is renewed; written to."""

    clearance: np.ndarray  # clearance, source: (nx, ny) as in the field
    source: np.ndarray
    free: np.ndarray  # (nx, ny) as in the record
    stale: np.ndarray  # (nx, ny) whether the clearance has to be computed anew
    grid: Grid  # grid of the nodes
    radius: float  # radius of the disc [m]


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
