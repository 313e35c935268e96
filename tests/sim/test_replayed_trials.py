"""Trials are recorded and replayed in one go, to the last bit."""

import pytest

from collplan_core.parameters import Settings
from collplan_core.replay.comparison import compare
from collplan_core.replay.journal import CONTROLLER, PLANNER
from collplan_core.replay.reading import events_of, rows_of
from collplan_core.worlds import load_world
from omnipuck_sim.trial import run_trial

FEW = {"time_to_goal.proposals": 20}
"""Of what refinement tries: a plan is as much one as with more."""


@pytest.mark.parametrize(
    ("strategy", "values"),
    [
        ("harness", {"simulator.mocap_yaw_noise": 0.01, "simulator.mocap_latency": 0.02}),
        ("bounce", {"trial.known_map": True, **FEW}),
        ("avoid", {"lidar.sensor": "low_cost", "limits.scan_age": 0.35, **FEW}),
    ],
)
def test_a_trial_is_replayed_to_the_last_bit(tmp_path, strategy, values):
    path, chosen = tmp_path / "trial.jsonl", {"planner.strategy": strategy, "trial.timeout": 1.2, **values}
    run_trial(load_world("u:17"), Settings().with_values(chosen), 1, journal=path)
    lines = path.read_text().splitlines()
    (planner,), (controller,) = (compare(of, events_of(rows_of(lines, path.name), of)) for of in (PLANNER, CONTROLLER))
    assert (planner.end, controller.end) == (None, None), f"{planner.end}\n{controller.end}"
    assert planner.plans >= 6
    assert controller.commands > 20
