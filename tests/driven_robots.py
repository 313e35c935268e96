"""A simulated robot driven round a room by hand, and its LIDAR of a drawn mount, stamp and sweep."""

import math
from dataclasses import dataclass

import numpy as np

from collplan_core.mounting.agreement import Mount
from collplan_core.mounting.driven import Driven
from collplan_core.worlds import World
from collplan_core.worlds.raycast import cast_beams

BEAMS, TURN, POSES = 240, 0.125, 20.0
BETWEEN = TURN / BEAMS
ANGLES = -math.pi + math.tau / BEAMS * np.arange(BEAMS)
ROOM = World(
    name="hall",
    walled=True,
    bounds=(-3.0, -2.0, 3.5, 2.5),
    polygons=(np.array([(1.6, -2.0), (2.4, -2.0), (2.4, -1.0), (1.6, -1.0)]),),
    circles=((-2.3, 1.6, 0.25), (0.4, 2.1, 0.15), (-1.5, -1.6, 0.2)),
)


def drawn_mount(seed: int) -> Mount:
    """A mount anywhere within 0.3 m, either way up, swept in any order, stamped 0.5 s late to 0.1 s early."""
    random = np.random.default_rng(seed)
    away, towards, yaw = random.uniform(0.0, 0.3), *random.uniform(-math.pi, math.pi, 2)
    late, sweep = random.uniform(-0.5, 0.1), int(random.integers(-1, 2))
    return Mount(late, away * math.cos(towards), away * math.sin(towards), yaw, sweep, bool(random.integers(2)))


@dataclass(frozen=True)
class Drive:
    """Where the robot is at a time [s]: on a figure of eight, or at rest."""

    moves: bool = True

    def poses(self, times: np.ndarray) -> np.ndarray:
        """(n, 3) x, y [m] and yaw [rad], not wrapped."""
        times = times if self.moves else np.zeros_like(times)
        phase = 0.35 * times
        x, y = 1.3 * np.sin(phase), 0.8 * np.sin(2.0 * phase)
        heading = np.unwrap(np.arctan2(1.6 * np.cos(2.0 * phase), 1.3 * np.cos(phase)))
        return np.column_stack([x, y, heading])


def driven(mount: Mount, drive: Drive, duration: float = 25.0, seed: int = 0) -> Driven:
    """What is recorded of it: exact odometry, and ranges with 8 mm of noise, NaN where one in fifty is lost."""
    random = np.random.default_rng(seed)
    times, stamps = np.arange(0.0, duration, 1.0 / POSES), np.arange(0.5, duration - 1.0, TURN)
    beams = np.arange(BEAMS)
    offsets = mount.late + BETWEEN * abs(mount.sweep) * (beams if mount.sweep > 0 else beams[::-1])
    ranges = []
    for stamp in stamps:
        robot = drive.poses(stamp + offsets)
        c, s = np.cos(robot[:, 2]), np.sin(robot[:, 2])
        origins = robot[:, :2] + np.column_stack([c * mount.x - s * mount.y, s * mount.x + c * mount.y])
        bearings = robot[:, 2] + mount.yaw + (-ANGLES if mount.mirrored else ANGLES)
        ranges.append(cast_beams(ROOM, origins, bearings) + random.normal(0.0, 0.008, BEAMS))
    lost = random.random((len(stamps), BEAMS)) < 0.02
    return Driven(times, drive.poses(times), stamps, np.where(lost, np.nan, ranges), ANGLES, BETWEEN)
