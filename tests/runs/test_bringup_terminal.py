"""What is typed to bringup and what it prints: options, the line that repeats a run, progress, laps."""

import itertools
import shlex
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from collplan_core.evaluation.run_end import CANCELED, REACHED, STUCK, TIMEOUT
from collplan_ros.bringup import driving
from collplan_ros.bringup.driving import Bringup
from collplan_ros.bringup.ending import EMERGENCY_STOP
from collplan_ros.bringup.options import Options, parse


def test_the_line_that_repeats_a_run_gives_what_was_asked_for(monkeypatch):
    monkeypatch.setattr("sys.argv", [".venv/bin/bringup", "--seed", "3"])
    params = Path("the runs/latest/parameters.yaml")
    for goal, network, namespace, scan in itertools.product(
        [(2.0, 0.4), (-1e-05, -3.0)], [None, "subnet"], ["/", "/lab/robot1"], ["sim", "real"]
    ):
        asked = {"goal": goal, "network": network, "namespace": namespace, "scan": scan, "max_speed": 0.9}
        first = Options(robot="serial:/dev/my robot", **asked)
        program, *arguments = shlex.split(first.repeated(params, np.array(goal)))
        again = parse(arguments)
        assert (program, again.robot, again.goal, again.network) == (".venv/bin/bringup", first.robot, goal, network)
        assert (again.max_speed, again.graph, again.params) == (0.9, namespace, params)
        assert (again.scan, again.world) == (first.scan, None)


def test_what_is_typed_is_taken_or_refused_by_its_name(capsys):
    assert parse(["--goal", "1,-2"]).goal == parse(["--goal", "1", "-2"]).goal == (1.0, -2.0)
    assert parse([]).graph == "/"
    assert parse(["--robot", "base:/cmd_vel"]).graph == "/collplan"
    assert parse(["--robot", "base:/cmd_vel", "--namespace", "/"]).graph == "/"
    assert parse(["--namespace", "robot1"]).graph == parse(["--namespace", "/robot1"]).graph == "/robot1"
    for option, *wrong in (["--goal", "1"], ["--goal", "1", "2", "3"], ["--goal", "a,b"], ["--namespace", "1st"]):
        with pytest.raises(SystemExit, match="2"):
            parse([option, *wrong])
        said = capsys.readouterr().err
        assert option.strip("-") in said
        assert all(each in said for each in wrong)
        assert "expected" in said


# ---- there and back: which ends come when, and what a person may do in between

ENDS = [np.array([2.0, 0.0]), np.array([0.0, 0.0])]


class Over(Exception):
    """Ends the laps as a signal does."""


class FakeDriver:
    """Has these outcomes, then is interrupted; a person gives a goal each third look, which ends three looks later."""

    def __init__(self, *outcomes: str) -> None:
        self.outcomes, self.did, self.looks, self.said = iter(outcomes), [], itertools.count(), []
        self.now, self.progress = time.monotonic, SimpleNamespace(say=self.said.append)
        self.preparation = SimpleNamespace(ends=ENDS)

    def drive(self, goal):
        for outcome in self.outcomes:
            self.did.append(tuple(goal.tolist()))
            return outcome
        raise Over

    def come_to_rest(self):
        self.did.append("rest")

    def wait(self, condition):
        while not condition():
            pass

    def reason(self, outcome):
        return f"why {outcome}"

    @property
    def goal_is_active(self):
        active = next(self.looks) // 3 % 2 == 1
        if active and self.did[-1] != "a goal":
            self.did.append("a goal")
        return active


def test_it_goes_to_and_fro_and_waits_for_the_goal_of_a_person_who_has_stopped_it(monkeypatch):
    monkeypatch.setattr(driving, "PAUSE", 0.0)
    there, back = (2.0, 0.0), (0.0, 0.0)
    for outcome in (REACHED, TIMEOUT, STUCK, CANCELED, EMERGENCY_STOP):
        driver = FakeDriver(outcome, REACHED)
        with pytest.raises(Over):
            Bringup.drive_laps(driver)
        is_stopped = outcome in (CANCELED, EMERGENCY_STOP)
        assert driver.did == [there, "rest", *(["a goal"] if is_stopped else []), back, "rest"], outcome
        assert len(driver.said) == (outcome != REACHED)
        assert is_stopped or all(each == f"why {outcome}" for each in driver.said)
