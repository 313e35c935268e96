"""Trials of a robot whose motion or whose poses are not what they seem: late, turned, not at all, of another body."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from shifted_starts import each_shift, shifted
from watched_trials import Turned, Watched, watched_trial

from collplan_core.control.brush import RESTS
from collplan_core.control.motion_monitor import LATE, REVERSED, MotionVerdict
from collplan_core.loop.controller_loop import BRUSHED
from collplan_core.worlds import Mover, parse_world

HALL = parse_world({"name": "hall", "bounds": [-1, -1, 6, 1], "start": [0.0, 0.0], "goal": [5.0, 0.0]}, "hall")
LOW_COST = {"lidar__sensor": "low_cost", "simulator__mocap_latency": 0.03, "simulator__mocap_yaw_noise": 0.01}


def run(nodes=Watched, world=HALL, strategy="avoid", seed=1, timeout=2.0, **values):
    return watched_trial(world, strategy, seed, nodes, trial__timeout=timeout, **values)


def test_late_poses_stop_it_within_0_3_s_of_its_first_motion_and_turned_axes_within_0_3_m():
    late, turned = run(simulator__mocap_latency=0.2), run(partial(Turned, math.pi / 2), strategy="harness")
    assert late.last_moving_command <= late.seen_moving + 0.3
    assert late.said[-1].held
    assert turned.result.path_length <= 0.3
    for watched, kind in ((late, LATE), (turned, REVERSED)):
        assert kind in {row.kind for row in watched.said}


@each_shift
def test_no_false_stop_with_low_cost_sensors(shift):
    watched = run(Watched, shifted("baffles:1000", shift), "bounce", 3, 6.0, **LOW_COST)
    assert len(watched.said) > 30
    assert not any(row.held for row in watched.said)
    assert watched.result.path_length > 1.0
    assert watched.loop.controller.motion.verdict.delay == pytest.approx(0.03, abs=0.05)


class Struck(Watched):
    """It stands until a mover strikes it, and then seems not to obey."""

    def planner(self) -> None:
        if self.record.touches:
            super().planner()

    def controller(self) -> None:
        motion, touches = self.loop.controller.motion, self.record.touches
        judge = motion.judge
        if touches and self.simulator.time < touches[0].time + 0.1:
            motion.judge = lambda *given: setattr(motion, "verdict", MotionVerdict(REVERSED, reason="turned"))
        super().controller()
        motion.judge = judge


def test_a_robot_that_a_mover_strikes_softly_stands_and_goes_on_slowly():
    walk = Mover(0.12, np.array([[0.0, 0.45], [0.0, 0.19]]), 0.15, to_and_fro=False)
    watched = run(Struck, replace(HALL, movers=(walk,)), timeout=4.5)
    begun, said = watched.result.touches[0].time, [row for row in watched.said if BRUSHED in row.reason]
    assert not any(row.held for row in watched.said)
    assert not any(row.speed for row in watched.said if begun < row.time < begun + RESTS)
    assert any(row.speed for row in said)
    assert max(row.speed for row in said) <= 0.3 + 1e-9
