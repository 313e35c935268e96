"""Trials are recorded and replayed in one go, to the last bit; whatever was changed shows where and when."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_core.replay.comparison import Comparison, Difference, compare
from collplan_core.replay.journal import CONTROLLER, PLANNER
from collplan_core.replay.reading import Call, events_of, rows_of
from collplan_core.worlds import load_world
from omnipuck_sim.trial import run_trial

FEW = {"time_to_goal.proposals": 20}
"""Of what refinement tries: a plan is as much one as with more."""


def recorded(folder: Path, world: str, strategy: str, seed: int = 1, **values: object) -> tuple[str, ...]:
    """The lines of the journal of a trial."""
    path = folder / "trial.jsonl"
    chosen = {"planner.strategy": strategy, "trial.timeout": 3.0, **values}
    run_trial(load_world(world), Settings().with_values(chosen), seed, journal=path)
    return tuple(path.read_text().splitlines())


@cache
def driven(folder: Path) -> tuple[str, ...]:
    return recorded(folder, "u:17", "bounce", **FEW)


@pytest.fixture
def lines(tmp_path_factory):
    return driven(tmp_path_factory.getbasetemp())


def compared(lines, of: str) -> Comparison:
    rows = rows_of(lines, "trial.jsonl")
    (found,) = compare(of, events_of(rows, of))
    return found


def assert_equal(lines, fewest_plans: int = 8) -> None:
    planner, controller = compared(lines, PLANNER), compared(lines, CONTROLLER)
    assert (planner.end, controller.end) == (None, None), f"{planner.end}\n{controller.end}"
    assert planner.plans >= fewest_plans
    assert controller.commands > 20


@pytest.mark.parametrize(
    ("strategy", "values"),
    [
        ("harness", {"simulator.mocap_yaw_noise": 0.01, "simulator.mocap_latency": 0.02}),
        ("custom", {"weights.risk": 30.0, "local_map.predicted": "printed"}),
        ("bounce", {"trial.known_map": True, **FEW}),
        ("avoid", {"lidar.sensor": "low_cost", "limits.scan_age": 0.35, **FEW}),
    ],
)
def test_a_trial_is_replayed_to_the_last_bit(tmp_path, strategy, values):
    assert_equal(recorded(tmp_path, "u:17", strategy, **{"trial.timeout": 1.2, **values}), fewest_plans=6)


def without_looks(row):
    return {
        **row,
        "calls": [{k: v for k, v in call.items() if k != "deadline_checks"} for call in row.get("calls", ())],
    }


def test_so_is_one_in_which_a_clock_ends_refinement_and_without_its_decisions_the_plans_are_others(tmp_path):
    budget = {"time_to_goal.time_budget": 0.003, "time_to_goal.proposals": 20000, "trial.timeout": 1.0}
    lines = recorded(tmp_path, "u:17", "bounce", **budget)
    assert_equal(lines, fewest_plans=6)
    looks = [
        call.deadline_checks
        for call in events_of(rows_of(lines, ""), PLANNER)
        if isinstance(call, Call) and call.deadline_checks
    ]
    assert len(looks) >= 6
    rows = [json.loads(line) for line in lines]
    changed = [json.dumps(without_looks(row) if row.get("number") else row) for row in rows]
    assert isinstance(compared(changed, PLANNER).end, Difference)


def test_the_journal_changes_nothing(tmp_path):
    settings = Settings().with_values({"planner.strategy": "bounce", "trial.timeout": 1.0, **FEW})
    one, other = (run_trial(load_world("u:17"), settings, 1, journal=path) for path in (tmp_path / "one", None))
    np.testing.assert_array_equal(one.trajectory, other.trajectory)
