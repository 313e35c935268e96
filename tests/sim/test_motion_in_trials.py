"""Trials of a robot whose motion or whose poses are not what they seem: late, turned, not at all, of another body."""

import math
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
import pytest
from shifted_starts import each_shift, shifted

from collplan_core.control.motion_monitor import LATE, REVERSED
from collplan_core.loop.controller_loop import WHY_KIDNAPPED, ControllerLoop
from collplan_core.parameters import Settings
from collplan_core.worlds import load_world, parse_world
from omnipuck_sim.robot.noise import faulty
from omnipuck_sim.robot.physics import Simulator
from omnipuck_sim.trial import run_trial

HALL = parse_world({"name": "hall", "bounds": [-1, -1, 6, 1], "start": [0.0, 0.0], "goal": [5.0, 0.0]}, "hall")
LOW_COST = {"lidar.sensor": "low_cost", "simulator.mocap_latency": 0.03, "simulator.mocap_yaw_noise": 0.01}
VISIBLE = 0.01
"""Way from which a motion is seen [m]."""


@dataclass
class Watched:
    """What the controller said of each period, and where it believed the robot."""

    times: list[float] = field(default_factory=list)
    speeds: list[float] = field(default_factory=list)
    kinds: list[str] = field(default_factory=list)
    stops: list[str] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)
    poses: list[tuple[float, float, float]] = field(default_factory=list)
    delay: float = math.nan

    @property
    def seen_moving(self) -> float:
        """When the first motion was seen [s]."""
        _, x, y = self.poses[0]
        return next(t for t, px, py in self.poses if math.hypot(px - x, py - y) > VISIBLE)

    @property
    def last_moving_command(self) -> float:
        return max((t for t, speed in zip(self.times, self.speeds, strict=True) if speed > 0.0), default=-math.inf)


@pytest.fixture
def watched(monkeypatch):
    """A Watched that fills while trials run."""
    seen = Watched()
    tick, take_pose = ControllerLoop.tick, ControllerLoop.take_pose

    def ticked(self, local):
        command = tick(self, local)
        seen.times.append(local)
        seen.speeds.append(float(np.hypot(*command.velocity)))
        seen.kinds.append(self.motion.verdict.kind)
        seen.stops.append(self.held)
        seen.reasons.append(command.reason)
        seen.delay = self.motion.verdict.delay
        return command

    def posed(self, state, local):
        seen.poses.append((local, *state.position.tolist()))
        return take_pose(self, state, local)

    monkeypatch.setattr(ControllerLoop, "tick", ticked)
    monkeypatch.setattr(ControllerLoop, "take_pose", posed)
    return seen


def run(shift, world=HALL, strategy="avoid", seed=1, timeout=2.0, **values):
    named = {key.replace("__", "."): value for key, value in values.items()}
    settings = Settings().with_values({"planner.strategy": strategy, "trial.timeout": timeout, **named})
    return run_trial(shifted(world, shift), settings, seed)


@each_shift
@pytest.mark.parametrize(("latency", "strategy"), [(0.2, "avoid"), (0.5, "harness")])
def test_late_poses_stop_it_within_0_3_s_of_its_first_motion(watched, latency, strategy, shift):
    run(shift, strategy=strategy, simulator__mocap_latency=latency)
    assert watched.last_moving_command <= watched.seen_moving + 0.3
    assert watched.stops[-1]
    assert LATE in watched.kinds


def turn_commands(monkeypatch, matrix):
    command = Simulator.command

    def commanded(self, velocity, yaw_rate):
        command(self, matrix @ np.asarray(velocity), yaw_rate)

    monkeypatch.setattr(Simulator, "command", commanded)


@each_shift
@pytest.mark.parametrize(("angle", "strategy"), [(math.pi / 2, "avoid"), (math.pi, "harness")])
def test_turned_axes_stop_it_within_0_3_m(watched, monkeypatch, angle, strategy, shift):
    c, s = math.cos(angle), math.sin(angle)
    turn_commands(monkeypatch, np.array([[c, -s], [s, c]]))
    result = run(shift, strategy=strategy)
    assert result.path_length <= 0.3
    assert REVERSED in watched.kinds


@each_shift
def test_no_false_stop_with_low_cost_sensors(watched, shift):
    result = run(shift, load_world("baffles:1000"), "bounce", 3, 6.0, **LOW_COST)
    assert len(watched.times) > 30
    assert not any(watched.stops)
    assert result.path_length > 1.0
    assert watched.delay == pytest.approx(0.03, abs=0.05)


@each_shift
def test_poses_that_are_late_cost_less_where_planner_and_controller_are_told(shift):
    late = {"simulator__mocap_latency": 0.06, "seed": 5, "timeout": 8.0}
    untold, told = {"robot__learning": "off"}, {"robot__motion_delay": 0.06}
    serpentine = load_world("serpentine:2")
    lost, known = (run(shift, serpentine, "bounce", **late, **each).arrival_time for each in (untold, told))
    assert known < lost - 0.05


FAULT_AT = 1.2
LIMIT = 0.15


def another_body(sample):
    return replace(sample, position=sample.position + np.array([1.5, 0.0]))


def with_false_poses(monkeypatch, fault, lasts=math.inf) -> None:
    measure = Simulator.measured_pose

    def measured(self):
        sample = measure(self)
        return fault(sample) if FAULT_AT <= self.time < FAULT_AT + lasts else sample

    monkeypatch.setattr(Simulator, "measured_pose", measured)


@each_shift
@pytest.mark.parametrize(
    ("fault", "strategy", "why"),
    [
        (partial(faulty, fault="yaw_90"), "avoid", "pose refused"),
        (partial(faulty, fault="tilt"), "harness", "pose refused"),
        (partial(faulty, fault="lift"), "harness", "pose refused"),
        (another_body, "avoid", WHY_KIDNAPPED),
    ],
)
def test_under_false_poses_it_stands_within_0_15_s_and_for_as_long_as_they_last(
    watched, monkeypatch, fault, strategy, why, shift
):
    with_false_poses(monkeypatch, fault)
    run(shift, strategy=strategy, timeout=2.5)
    times, speeds = np.array(watched.times), np.array(watched.speeds)
    assert speeds[times < FAULT_AT].max() > 0.5
    later = speeds[times > FAULT_AT + LIMIT]
    assert len(later) > 15
    assert not later.any()
    assert why in watched.reasons[-1]
