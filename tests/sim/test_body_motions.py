"""The markers' place on the simulated robot, found from its motions (simulated, noise of the motion capture 2 mm)."""

import math

import numpy as np
import pytest

from collplan_core.calibration.body_motions import (
    CAREFUL_ROUNDS,
    MOST_DISTANCE,
    QUICK_ROUNDS,
    Strayed,
    careful,
    drive_each_way,
    estimate,
    one_more_round,
    quick,
)
from collplan_core.parameters import Settings
from collplan_core.worlds import World
from omnipuck_sim.robot.physics import Simulator

MIDDLE = np.array([1.5, 1.5])
HALL = World("hall", (), np.zeros((0, 3)), (0.0, 0.0, 3.0, 3.0), True, MIDDLE, None)
OFFSET = (0.02, -0.01, math.radians(6.0))
QUIET = {"noise": 0.1, "mocap_noise": 0.02}


class Stepped:
    """Drives the simulator, faster than real time.

    Args:
        bias: (2,) velocity that the wheels add while they turn [m/s, robot frame].
        scale: it goes so many times as fast as it is commanded.
        by_wheels: as behind wheel speeds, whose velocity is never zero to the last bit while the robot turns in place,
            so that the wheels' noise acts then too.
    """

    def __init__(self, seed=0, offset=OFFSET, *, bias=(0.0, 0.0), scale=1.0, by_wheels=False, **simulation):
        placed = zip(("marker_offset_x", "marker_offset_y", "marker_offset_yaw"), offset, strict=True)
        values = {f"simulator.{key}": value for key, value in [*placed, *simulation.items()]}
        self.settings = Settings().with_values(values)
        self.simulator = Simulator(HALL, self.settings, seed)
        self.simulator.place(MIDDLE, yaw=float(seed))
        self.farthest = 0.0
        self._bias = np.array(bias)
        self._side = scale * np.ones(2)
        self._least = np.array([1e-12 if by_wheels else 0.0, 0.0])

    def drive(self, velocity, yaw_rate, duration, is_near):
        poses = self._run(self._side * velocity + self._bias + self._least, yaw_rate, duration, is_near)
        self._run(np.zeros(2), 0.0, 0.6)
        return poses

    def rest(self):
        return self._run(np.zeros(2), 0.0, 0.25)

    def _run(self, velocity, yaw_rate, duration, is_near=lambda pose: True):
        poses = []
        for _ in range(round(100 * duration)):
            self.simulator.command(velocity, yaw_rate)
            for _ in range(round(self.settings.simulator.physics_rate / 100)):
                self.simulator.step()
            poses.append(self.simulator.measured_pose())
            self.farthest = max(self.farthest, float(np.linalg.norm(self.simulator.state.position - MIDDLE)))
            if not is_near(poses[-1]):
                break
        return poses


def checked(robot):
    """The estimate, and how long it took [s]."""
    lag = robot.settings.robot.velocity_lag
    slow, pace = careful(robot.settings.robot), quick(robot.settings.robot)
    motions = drive_each_way(robot, slow, lag)
    while len(motions.turns) < CAREFUL_ROUNDS:
        motions = one_more_round(robot, motions, slow, lag)
    if not estimate(motions, lag).is_certain:
        for _ in range(QUICK_ROUNDS):
            motions = one_more_round(robot, motions, pace, lag)
    return estimate(motions, lag), robot.simulator.time


def assert_found(known, offset=OFFSET):
    x, y, yaw = offset
    found = known.offset
    assert known.is_certain
    assert math.hypot(found.x - x, found.y - y) < 0.006
    assert abs(math.remainder(found.yaw - yaw, math.tau)) < math.radians(1.6)
    assert known.axes.scale == pytest.approx(1.0, abs=0.05)
    assert known.turns.share == pytest.approx(1.0, abs=0.01)


def test_wheels_as_noisy_as_assumed_take_more_motions():
    """0.06 m/s of noise for 0.05 s each, 0.03 m/s of bias."""
    robot = Stepped(by_wheels=True)
    known, took = checked(robot)
    assert_found(known)
    assert robot.farthest < MOST_DISTANCE
    assert 100.0 < took < 155.0


def test_a_bias_of_the_wheels_is_no_offset():
    """Of 0.03 m/s in the robot's frame: a turn one way at 1 rad/s would show 30 mm."""
    known, _ = checked(Stepped(bias=(0.02, -0.03), **QUIET))
    assert_found(known)
    found = known.axes.robot_bias * np.exp(1j * known.offset.yaw)
    assert abs(found - (0.02 - 0.03j)) < 0.005
    assert abs(known.axes.room_bias) < 0.025  # the simulator's own


def test_a_robot_that_drifts_away_is_not_driven_on():
    robot = Stepped(bias=(0.2, 0.0), **QUIET)
    with pytest.raises(Strayed, match="began"):
        checked(robot)
    assert robot.farthest < MOST_DISTANCE + 0.2
