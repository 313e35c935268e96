"""Boundaries kept from earlier scans as one record."""

from dataclasses import dataclass

import numpy as np

from collplan_core.time_to_goal_planner.boundary_memory.clearance import ClearanceField


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
