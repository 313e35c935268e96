"""The sweeps of a spinning LIDAR on a moving robot, one after the other."""

import numpy as np

from collplan_core.parameters import Lidar
from collplan_core.scan import Scan
from collplan_core.sensing.pose_history import PoseHistory
from collplan_core.sensing.spinning_lidar import SPINNING_SENSORS, SpinningSensor, swept_scan
from collplan_core.state import State
from collplan_core.worlds import World

STREAM = 100
"""Key of the noise's stream among those of a seed; the simulator's own are counted from 0."""

LONGEST_GAP = 1.1
"""Time between two poses over which motion is still interpolated, in sweeps."""


class Sweeps:
    """Takes the robot's poses and gives a scan once its sweep has ended and the sensor's latency has passed.

    Between two poses the robot is taken to move evenly. After a gap longer than a sweep, or a clock set back, a sweep
    begins anew.
    """

    def __init__(self, world: World, sensor: SpinningSensor, lidar: Lidar, seed: int) -> None:
        """Equal poses and seeds give equal scans; `lidar` says where the sensor truly is on the robot."""
        self._world = world
        self._sensor = sensor
        self._lidar = lidar
        self._random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(STREAM,)))
        self._poses = PoseHistory(3.0 * sensor.sweep_time)
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
        if state.stamp < self._begun + sensor.sweep_time + sensor.latency - 5e-7:
            return None
        begun, self._begun = self._begun, self._begun + sensor.sweep_time
        poses = self._poses.at_each(sensor.beam_times(begun))
        return None if poses is None else swept_scan(self._world, poses, begun, sensor, self._lidar, self._random)


def sweeps_of(world: World, lidar: Lidar, seed: int) -> Sweeps | None:
    """The sweeps of the sensor that `lidar.sensor` names; None for ideal, whose beams are all of one instant."""
    sensor = SPINNING_SENSORS.get(lidar.sensor)
    return None if sensor is None else Sweeps(world, sensor, lidar, seed)
