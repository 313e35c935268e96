"""The watch over the robot's motion: what may push it is no evidence against its wheels."""

import numpy as np
import pytest

from collplan_core.command import FREE_SPACE, Command
from collplan_core.control.motion_monitor import SLIP
from collplan_core.loop.motion_watch import MotionWatch
from collplan_core.movers.record import NO_MOVERS, Movers
from collplan_core.parameters import Settings
from collplan_core.state import State

SETTINGS = Settings()
BESIDE = SETTINGS.robot.radius + 0.12


def mover_at(x: float, velocity: float = 0.0, stamp: float = 0.0) -> Movers:
    one = np.ones(1)
    return Movers(
        stamp, np.zeros(1, int), np.array([(x, 0.0)]), np.array([(velocity, 0.0)]), 0.12 * one, 0.0 * one, stamp * one
    )


@pytest.mark.parametrize(
    ("movers", "pushed"),
    [
        (NO_MOVERS, False),
        (mover_at(BESIDE + 0.02), True),
        (mover_at(BESIDE + 0.05), False),
        (mover_at(BESIDE + 0.10, 0.6), True),  # it may have turned back since it was seen
        (mover_at(BESIDE + 0.60, -0.6), False),
    ],
)
def test_a_mover_beside_the_robot_may_push_it(movers, pushed):
    watch = MotionWatch()
    watch.take_pose(State(0.0, np.zeros(2), np.zeros(2), 0.0), 0.0, True, SETTINGS, movers)
    assert watch.pushed == pushed


@pytest.mark.parametrize("is_seen", [True, False])
def test_a_robot_that_a_mover_pushes_back_gives_no_reason_to_doubt_its_wheels(is_seen):
    watch = MotionWatch()
    for k in range(200):
        now, x = 0.01 * k, -0.005 * k
        watch.take_pose(State(now, np.array([x, 0.0]), np.array([-0.5, 0.0]), 0.0), now, True, SETTINGS,
                        mover_at(x + BESIDE, -0.5, now) if is_seen else NO_MOVERS)  # fmt: skip
        if k % 5 == 0:
            watch.commanded(Command(np.array([0.5, 0.0]), 0.0, FREE_SPACE, np.zeros(2)), now)
            watch.judge(now, SETTINGS)
    assert (watch.verdict.kind == SLIP) != is_seen
