"""The markers' place on the simulated robot, found from its motions (simulated, noise of the motion capture 2 mm)."""

import math

import numpy as np
import pytest

from collplan_core.calibration.body_motions import drive_each_way, turn_in_place
from collplan_core.calibration.mocap_offset import body_offset
from collplan_core.parameters import Settings
from collplan_core.worlds import World
from omnipuck_sim.robot.physics import Simulator

HALL = World("hall", (), np.zeros((0, 3)), (0.0, 0.0, 3.0, 3.0), True, np.array([1.5, 1.5]), None)


class Stepped:
    """Drives the simulator, faster than real time."""

    def __init__(self, values, seed, yaw=0.0):
        self.settings = Settings().with_values(values)
        self.simulator = Simulator(HALL, self.settings, seed)
        self.simulator.place(np.array([1.5, 1.5]), yaw=yaw)

    def drive(self, velocity, yaw_rate, duration):
        poses = self._run(velocity, yaw_rate, duration)
        self._run((0.0, 0.0), 0.0, 0.8)
        return poses

    def rest(self):
        return self._run((0.0, 0.0), 0.0, 0.4)

    def _run(self, velocity, yaw_rate, duration):
        poses = []
        for _ in range(round(100 * duration)):
            self.simulator.command(np.array(velocity), yaw_rate)
            for _ in range(round(self.settings.simulator.physics_rate / 100)):
                self.simulator.step()
            poses.append(self.simulator.measured_pose())
        return poses


def found(stepped):
    lever, share = turn_in_place(stepped, 1.0)
    axes = drive_each_way(stepped, lever, 1.2)
    return body_offset(axes, lever), axes, share


def placed(x, y, yaw, **noise):
    offset = {"marker_offset_x": x, "marker_offset_y": y, "marker_offset_yaw": yaw}
    return {f"simulator.{key}": value for key, value in {**offset, **noise}.items()}


@pytest.mark.parametrize("seed", range(6))
def test_the_offset_is_right_within_2_mm_and_1_degree(seed):
    x, y, yaw = np.random.default_rng(seed).uniform((-0.05, -0.05, -math.pi), (0.05, 0.05, math.pi)).tolist()
    stepped = Stepped(placed(x, y, yaw, actuation_noise=0.01, actuation_bias=0.01), seed, yaw=seed)
    offset, axes, share = found(stepped)
    assert math.hypot(offset.x - x, offset.y - y) < 0.002
    assert abs(math.remainder(offset.yaw - yaw, math.tau)) < math.radians(1.0)
    assert axes.scale == pytest.approx(1.0, abs=0.05)
    # it is still turning when the command ends, a lag of 0.1 s of a turn of 6.3 s
    assert share == pytest.approx(1.0, abs=0.02)


def test_wheels_as_noisy_as_assumed_are_told_by_the_uncertainty():
    """0.06 m/s of actuation noise at 0.1 m/s: degrees, and the check says so."""
    runs = [found(Stepped(placed(0.03, -0.02, 0.17), seed))[:2] for seed in range(16)]
    errors = np.array([offset.yaw - 0.17 for offset, _ in runs])
    told = np.array([axes.uncertainty for _, axes in runs])
    assert math.radians(1.0) < np.sqrt(np.mean(told**2)) < math.radians(6.0)
    assert 0.5 < np.sqrt(np.mean(errors**2) / np.mean(told**2)) < 2.0


def test_no_offset_is_found_to_be_none():
    offset, _, _ = found(Stepped({"simulator.noise": 0.0}, 0))
    assert (offset.x, offset.y, offset.yaw) == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)
