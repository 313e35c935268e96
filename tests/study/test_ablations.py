"""The ablations: one change each, every reading with a printed form, and their table."""

import json

import pytest

from collplan_core.parameters import Settings
from collplan_study.analysis import statistics
from collplan_study.question.ablations import ABLATIONS, DEFAULTS
from collplan_study.question.grid import make_grid
from collplan_study.question.question import Question
from collplan_study.question.sources import load_sources
from collplan_study.report.write_report import write_report
from fake_studies import fake_study, reached

SOME = {name: ABLATIONS[name] for name in ("", "without R_ref", "a_max 3 m/s^2")}


@pytest.mark.parametrize("name", [name for name in ABLATIONS if name])
def test_each_changes_something_of_the_defaults(name):
    before = Settings().values()
    after = Settings().with_values(dict(ABLATIONS[name])).values()
    assert {key for key in after if after[key] != before[key]} == set(ABLATIONS[name]) != set()


def test_every_reading_that_has_a_printed_form_is_among_them():
    changed = {key: value for changes in ABLATIONS.values() for key, value in changes.items()}
    printed = {
        "planner.position_cost",
        "planner.turn_angle",
        "planner.gap_risk",
        "planner.approach_risk",
        "planner.frontiers",
        "planner.speeds",
        "planner.time_law",
        "controller.maneuver_rule",
        "local_map.predicted",
    }
    assert {key for key, value in changed.items() if value == "printed"} == printed
    numbers = {"planner.widest_gap": 100.0, "planner.shortest_frontier": 0.0, "planner.time_floor": 1e-9}
    assert numbers.items() <= changed.items()
    accelerations = {changes.get("robot.max_acceleration", 1.5) for changes in ABLATIONS.values()}
    assert accelerations == {1.0, 1.5, 2.0, 3.0}


def test_what_is_asked_by_default_is_a_grid_with_all_of_them():
    question = Question(**{**DEFAULTS, "worlds": ("random:0-1",), "ablations": True})
    grid = make_grid(question, load_sources(question.worlds, None, None), ABLATIONS)
    assert len(grid) == len(ABLATIONS) * 2 * 3 * DEFAULTS["trials"]
    assert {task.labels["ablation"] for task in grid} == set(ABLATIONS)


def test_the_table_says_what_a_change_costs(tmp_path, monkeypatch):
    monkeypatch.setattr(statistics, "RESAMPLES", 499)

    def slower_without(task):
        time = 3.0 + 0.1 * task.labels["trial"]
        return reached(time * (1.25 if task.labels["ablation"] == "without R_ref" else 1.0))

    question = Question(trials=6, map_periods=(0.2,), ablations=True)
    folder = fake_study(tmp_path / "study", slower_without, question, ablations=SOME)
    write_report(folder)
    found = json.loads((folder / "table.json").read_text())
    assert len(found["cases"]) == 1
    assert [row["ablation"] for row in found["ablations"]] == ["as shipped", "without R_ref", "a_max 3 m/s^2"]
    longer = [[each["value"] for each in row["longer"]] for row in found["ablations"]]
    assert longer[1] == pytest.approx([25.0] * 3)
    assert longer[0] == longer[2] == [0.0] * 3
    assert found["comparisons"]["ablations"] == 4
    assert "without R_ref" in (folder / "report.html").read_text()
