"""There and back: which ends come when, and what a person may do in between."""

import itertools
from collections.abc import Callable

import numpy as np
import pytest

from collplan_core.evaluation.run_end import CANCELED, REACHED, STUCK, TIMEOUT
from collplan_ros.bringup import laps
from collplan_ros.bringup.laps import EMERGENCY_STOP, drive_laps

ENDS = [np.array([2.0, 0.0]), np.array([0.0, 0.0])]


class Over(Exception):
    """Ends the laps as a signal does."""


class FakeDriver:
    """Has these outcomes, then is interrupted; a person gives a goal each third look, which ends three looks later."""

    def __init__(self, outcomes: list[str]) -> None:
        self.outcomes = outcomes
        self.did: list[object] = []
        self.looks = itertools.count()

    def drive(self, goal: np.ndarray | None = None) -> str:
        if not self.outcomes:
            raise Over
        assert goal is not None
        self.did.append(tuple(goal.tolist()))
        return self.outcomes.pop(0)

    def come_to_rest(self) -> None:
        self.did.append("rest")

    def wait(self, condition: Callable[[], bool]) -> None:
        while not condition():
            pass

    def reason(self, outcome: str) -> str:
        return f"why {outcome}"

    @property
    def goal_is_active(self) -> bool:
        active = next(self.looks) // 3 % 2 == 1
        if active and self.did[-1] != "a person's goal":
            self.did.append("a person's goal")
        return active


@pytest.fixture(autouse=True)
def _short_pause(monkeypatch):
    monkeypatch.setattr(laps, "PAUSE", 0.0)


def driven(*outcomes: str) -> tuple[list[object], list[str]]:
    driver, said = FakeDriver(list(outcomes)), []
    with pytest.raises(Over):
        drive_laps(driver, ENDS, said.append)
    return driver.did, said


@pytest.mark.parametrize("outcome", [REACHED, TIMEOUT, STUCK])
def test_it_goes_to_and_fro_and_rests_at_each_end(outcome):
    did, said = driven(*[outcome] * 3)
    assert did == [(2.0, 0.0), "rest", (0.0, 0.0), "rest", (2.0, 0.0), "rest"]
    assert said == ([] if outcome == REACHED else [f"why {outcome}"] * 3)


@pytest.mark.parametrize("outcome", [CANCELED, EMERGENCY_STOP])
def test_after_a_person_has_stopped_it_it_waits_for_that_persons_goal(outcome):
    did, said = driven(outcome, REACHED)
    assert did == [(2.0, 0.0), "rest", "a person's goal", (0.0, 0.0), "rest"]
    assert len(said) == 1
    assert said[0].endswith("the robot stands until you give it a goal")
