"""A low-cost spinning LIDAR on a moving robot in a known world: what each of its sweeps reports.

The sensor turns while the robot drives, so each beam is cast from where the robot was at the beam's own instant. A beam
has a width: where it straddles an edge, the range is a blend of both surfaces. Ranges have noise, and some are lost.
"""

from dataclasses import dataclass
from math import radians, tau

import numpy as np

from collplan_core.parameters import Lidar
from collplan_core.poses.pose_history import PoseHistory
from collplan_core.scan import Scan
from collplan_core.scans.placing import poses_of_sensor
from collplan_core.state import State
from collplan_core.worlds import World, load_world
from collplan_core.worlds.instant_lidar import MoverHistory, published, returned
from collplan_core.worlds.raycast import cast_beams

FOOTPRINT = np.linspace(-0.5, 0.5, 5)
"""Places across a beam's width at which it is sampled."""


STREAM = 100
"""Key of the noise's stream among those of a seed; the simulator's own are counted from 0."""

LONGEST_GAP = 1.1
"""Time between two poses over which motion is still interpolated, in sweeps."""


@dataclass(frozen=True)
class SpinningSensor:
    """Properties of a spinning LIDAR."""

    rate: float  # turns per second, each one scan [Hz]
    n_beams: int  # beams of a turn
    range_min: float  # range_min, range_max: limits of a valid range [m]
    range_max: float
    noise: float  # standard deviation of a range [m]
    noise_share: float  # further, independent standard deviation, as a share of the range
    lost: float  # share of the beams that report nothing
    divergence: float  # full width of a beam [rad]
    latency: float  # time from the end of a sweep to its message [s]

    @property
    def sweep_time(self) -> float:
        """Time of one turn [s]."""
        return 1.0 / self.rate

    @property
    def time_increment(self) -> float:
        """Time from beam to beam [s]."""
        return self.sweep_time / self.n_beams

    def beam_times(self, stamp: float) -> np.ndarray:
        """(n_beams,) the instant of each beam of a sweep that begins at `stamp` [s]."""
        return stamp + self.time_increment * np.arange(self.n_beams)


LD19 = SpinningSensor(
    # from the data sheet, typical values; the noise is that from 0.3 m on, 4500 ranges a second make 450 a turn
    rate=10.0,
    n_beams=450,
    range_min=0.02,
    range_max=12.0,
    noise=0.010,
    # the data sheet has none of these: assumed
    noise_share=0.005,
    lost=0.01,
    divergence=radians(0.5),
    latency=0.01,
)
"""LDROBOT LD19, a small time-of-flight sensor. Noise share, loss, width and latency are assumed."""

SPINNING_SENSORS = {"low_cost": LD19}
"""The sensors that `lidar.sensor` names, but for ideal."""


def swept_scan(
    world: World,
    poses: np.ndarray,
    stamp: float,
    sensor: SpinningSensor,
    lidar: Lidar,
    random: np.random.Generator,
    discs: np.ndarray | None = None,
) -> Scan:
    """The scan of one sweep.

    Args:
        poses: (n_beams, 3) x, y [m] and yaw [rad] of the robot at the instant of each beam.
        lidar: its true mounting pose on the robot, the direction of its first beam, and its fault.
        random: two draws a beam are taken from it, whatever the beam meets.
        discs: (n_beams, k, 3) x, y, radius [m] of the movers at the instant of each beam.
    """
    increment = tau / sensor.n_beams
    places = poses_of_sensor(poses, lidar.offset)
    turned = -increment if lidar.mirrored else increment
    angle_min = -lidar.angle_min if lidar.mirrored else lidar.angle_min
    angles = places[:, 2] + angle_min + turned * np.arange(sensor.n_beams)
    met = returned(blended(world, places[:, :2], angles, sensor, discs), increment, lidar.fault)
    ranges = noisy(met, sensor, random)
    return Scan(stamp, lidar.angle_min, increment, sensor.range_min, sensor.range_max, ranges, sensor.time_increment)


def blended(
    world: World, origins: np.ndarray, angles: np.ndarray, sensor: SpinningSensor, discs: np.ndarray | None = None
) -> np.ndarray:
    """(n,) mean range over the width of each beam [m], of the part that meets a surface within range_max.

    +Inf where no part does, -Inf from inside an obstacle. Takes origins (n, 2) [m] and angles (n,) [rad], world frame,
    and the movers' discs of each beam as `cast_beams` does.
    """
    each = (angles[:, np.newaxis] + sensor.divergence * FOOTPRINT).ravel()
    moved = None if discs is None else np.repeat(discs, len(FOOTPRINT), axis=0)
    ranges = cast_beams(world, np.repeat(origins, len(FOOTPRINT), axis=0), each, moved)
    ranges = ranges.reshape(len(angles), len(FOOTPRINT))
    met = ranges <= sensor.range_max
    count = met.sum(axis=1)
    return np.where(count > 0, np.where(met, ranges, 0.0).sum(axis=1) / np.maximum(count, 1), np.inf)


def noisy(ranges: np.ndarray, sensor: SpinningSensor, random: np.random.Generator) -> np.ndarray:
    """(n,) the ranges (n,) [m] as the sensor reports them: with noise, and NaN where one is lost."""
    errors, fates = random.standard_normal(len(ranges)), random.random(len(ranges))
    finite = np.where(np.isfinite(ranges), ranges, 0.0)
    measured = np.maximum(finite + np.hypot(sensor.noise, sensor.noise_share * finite) * errors, 0.0)
    return np.where(fates < sensor.lost, np.nan, np.where(np.isfinite(ranges), measured, ranges))


class Sweeps:
    """Takes the robot's poses and gives a scan once its sweep has ended and the sensor's latency has passed.

    Between two poses the robot is taken to move evenly. After a gap longer than a sweep, or a clock set back, a sweep
    begins anew.
    """

    def __init__(
        self, world: World, sensor: SpinningSensor, lidar: Lidar, seed: int, movers: MoverHistory | None = None
    ) -> None:
        """Equal poses, movers and seeds give equal scans; `lidar` has the sensor's true mounting pose on the robot."""
        self._world = world
        self._sensor = sensor
        self._lidar = lidar
        self._random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(STREAM,)))
        self._movers = movers or MoverHistory()
        # a message is not received before its stamp
        self._latency = max(sensor.latency, -lidar.stamp_offset - sensor.sweep_time)
        self._poses = PoseHistory(3.0 * sensor.sweep_time + self._latency - sensor.latency)
        self._last: Scan | None = None
        self._newest = self._begun = float("nan")

    def take_pose(self, state: State) -> Scan | None:
        """A pose; returns the scan that its stamp completes, if any."""
        sensor = self._sensor
        if state.stamp - self._newest > LONGEST_GAP * sensor.sweep_time:
            self._poses.clear()
        self._newest = state.stamp
        self._poses.add(state)
        if self._poses.at(self._begun) is None:
            self._begun = state.stamp
        # half a microsecond of tolerance: sums of decimal times must not decide
        if state.stamp < self._begun + sensor.sweep_time + self._latency - 5e-7:
            return None
        begun, self._begun = self._begun, self._begun + sensor.sweep_time
        times = sensor.beam_times(begun)
        poses, discs = self._poses.at_each(times), self._movers.at_each(times)
        if poses is None:
            return None
        lidar, n = self._lidar, sensor.n_beams
        order = {"forwards": np.arange(n), "backwards": np.arange(n)[::-1], "instant": np.zeros(n, int)}[lidar.sweep]
        stamp = begun - lidar.stamp_offset
        scan = swept_scan(self._world, poses[order], stamp, sensor, lidar, self._random, discs[order])
        self._last = published(scan, self._last, lidar.fault)
        return self._last


def sweeps_of(world: World, lidar: Lidar, seed: int, movers: MoverHistory | None = None) -> Sweeps | None:
    """The sweeps of the sensor that `lidar.sensor` names; None for ideal, whose beams are all of one instant."""
    sensor = SPINNING_SENSORS.get(lidar.sensor)
    return None if sensor is None else Sweeps(world, sensor, lidar, seed, movers)


def warm_up() -> None:
    """Compiles the casting by one sweep of a robot at rest, so that the first scan is not late."""
    world = load_world("corridor")
    assert world.start is not None, "the shipped arenas have a start"
    poses = np.tile((*np.asarray(world.start, dtype=float).tolist(), 0.0), (LD19.n_beams, 1))
    swept_scan(world, poses, 0.0, LD19, Lidar(), np.random.default_rng(0))
