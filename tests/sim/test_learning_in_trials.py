"""Trials of a robot that learns its drive: planner and controller use it."""

import pytest

from collplan_core.learning.drive import drive_of
from collplan_core.parameters import Settings
from collplan_core.worlds import load_world
from omnipuck_sim.trial import TrialNodes, run_trial

FEW = {"time_to_goal.proposals": 20}


def driven():
    """The two loops of a trial, and the drive of each plan beside the one in use when it was made."""
    made, plans = [], []

    class Kept(TrialNodes):
        def __init__(self, *given):
            super().__init__(*given)
            made.append(self)

        def _hear(self, decision, local):
            super()._hear(decision, local)
            if hasattr(decision, "plan"):
                plans.append((decision.plan.drive, self.loop.controller.drive.in_use))

    chosen = {"planner.strategy": "bounce", "trial.timeout": 8.0, "simulator.mass_ratio": 2.0, **FEW}
    run_trial(load_world("serpentine:2"), Settings().with_values(chosen), 1, nodes_class=Kept)
    return made[0].loop, plans


def test_a_load_is_learnt_within_seconds_and_planned_with():
    loop, plans = driven()
    in_use, learnt = loop.controller.drive.in_use, loop.controller.drive.learnt
    assert in_use.max_acceleration == pytest.approx(0.75, rel=0.05)
    assert learnt.max_acceleration.low < 0.75 < learnt.max_acceleration.high
    assert all(planned == used for planned, used in plans)
    assert plans[0][0] == drive_of(Settings().robot) != plans[-1][0]
    assert drive_of(loop.controller.settings.robot) == in_use
