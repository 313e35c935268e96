"""The study of bounces: the runs of its grid, the numbers of its tables."""

import json
from collections import Counter
from math import radians

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_core.strategies import TIME_TO_GOAL
from collplan_study.errors import StudyError
from collplan_study.question.grid import load_sources, make_grid
from collplan_study.question.question import parse, question_from
from collplan_study.question.specification import DEFAULTS, KNOWN_MAP, VARIANTS
from collplan_study.report.write_report import write_report
from fake_studies import fake_study, impact, reached, without_figures

WORLDS = ("l:0-5", "random:0-5", "pillars:0-5")
ASKED = question_from({**DEFAULTS, "bounces": True, "worlds": WORLDS, "seed": 5})
LOST, SAVED = "random:3", "pillars:2"
FACTORS = {"bounce": 0.9, "tolerate": 0.95, "avoid": 1.0, "stop_guarantee": 1.2}
SOME = {name: VARIANTS[name] for name in ("", KNOWN_MAP, "a_max 3 m/s^2")}


@pytest.fixture(scope="module")
def sources():
    return load_sources(WORLDS, None, None)


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    without_figures(monkeypatch)


def by_strategy(task):
    """bounce saves 10 % against avoid, but loses 20 % in one world and saves half in another; knowing doubles it."""
    labels = task.labels
    factor = FACTORS[labels["strategy"]]
    if labels["strategy"] == "bounce":
        factor = {LOST: 1.2, SAVED: 0.5}.get(labels["world"], factor)
    if labels["ablation"] == KNOWN_MAP:
        factor = {"bounce": 0.64, "avoid": 0.8}[labels["strategy"]]
    time = factor * np.random.default_rng(task.seed).normal(3.0, 0.2)
    length = {"bounce": 2.1}.get(labels["strategy"], 2.0)
    return {**reached(time, length), "deliberate_impacts": int(labels["strategy"] == "bounce")}


def impacts(task):
    bounces = task.labels["strategy"] == "bounce" and task.labels["ablation"] == ""
    return [impact(0.5, radians(6.0)), impact(0.1, radians(20.0)), impact(0.3)] if bounces else []


@pytest.fixture(scope="module")
def found(tmp_path_factory, sources):
    with pytest.MonkeyPatch.context() as patch:
        without_figures(patch)
        folder = fake_study(tmp_path_factory.mktemp("bounces") / "study", by_strategy, ASKED, sources, SOME, impacts)
        write_report(folder)
    return json.loads((folder / "table.json").read_text()), folder


def case(found, name, ablation=""):
    each = found["changes"] if ablation else found["cases"]
    return next(each for each in each if (each["case"]["name"], each["ablation"]) == (name, ablation))


def gain(found, name, other, ablation=""):
    return {each["measure"]: each for each in case(found, name, ablation)["comparisons"] if each["other"] == other}


def test_the_main_comparison_comes_first_and_world_by_world_and_rebounds_spread_in_all(sources):
    tasks = list(make_grid(ASKED, sources, VARIANTS))
    main, varied = tasks[: len(sources) * 4 * 2], tasks[len(sources) * 4 * 2 :]
    assert {task.labels["ablation"] for task in main} == {""}
    for place, source in enumerate(sources):
        of_world = main[8 * place : 8 * place + 8]
        assert {task.world.name for task in of_world} == {source.world.name}
        assert Counter(task.labels["strategy"] for task in of_world) == dict.fromkeys(TIME_TO_GOAL, 2)
    assert len(varied) == len(sources) * (len(VARIANTS) - 1) * 2
    assert {(task.labels["strategy"], task.labels["trial"]) for task in varied} == {("bounce", 0), ("avoid", 0)}
    for task in tasks:
        simulated = task.settings.simulator
        assert (simulated.restitution_spread, simulated.friction_spread) == (0.08, 0.04)
        assert task.settings.planner.map_period == task.labels["map_period_s"] == 0.05


def test_each_change_is_one_thing():
    known = Settings().values()
    changed = {name: {key for key in changes if known[key] != changes[key]} for name, changes in VARIANTS.items()}
    both = {"simulator.restitution", "rebound.restitution"}
    told = {"robot.mass", "robot.max_acceleration", "robot.velocity_lag"}
    assert [keys for keys in changed.values() if len(keys) > 1] == [both, both, told]
    assert changed[KNOWN_MAP] == {"trial.known_map"}


def test_savings_are_means_of_paired_ratios(found):
    table, _ = found
    first = gain(table, "2 families together", "avoid")
    assert (first["saved"]["worlds"], first["saved"]["pairs"]) == (12, 24)
    saved = first["saved"]["estimate"]
    assert saved["low"] < saved["value"] < saved["high"]
    for name, other, measure, expected in [
        ("2 families together", "avoid", "saved", (11 * 10.0 - 20.0) / 12),
        ("2 families together", "avoid", "slower", 100.0 / 12),
        ("2 families together", "avoid", "longer", 5.0),
        ("l", "stop_guarantee", "saved", 25.0),
        ("l", "tolerate", "saved", 100.0 * (1 - 0.9 / 0.95)),
        ("random", "stop_guarantee", "slower", 0.0),  # equal times in one world
        ("pillars", "avoid", "saved", (5 * 10.0 + 50.0) / 6),
    ]:
        assert gain(table, name, other)[measure]["estimate"]["value"] == pytest.approx(expected), (name, measure)
    assert [each["case"]["headline"] for each in table["cases"]] == [True, False, False, True]
    assert table["comparisons"] == {"main": 12, "other_map_periods": 0, "changes": 8}


def test_worlds_that_lose_are_named_and_first(found):
    table, folder = found
    worlds = case(table, "2 families together")["by_world"]
    assert (worlds[0]["world"], worlds[0]["pairs"]) == (LOST, 2)
    assert worlds[0]["saved"] == pytest.approx(-20.0)
    assert worlds[0]["ours_time"] == pytest.approx(1.2 * worlds[0]["other_time"])
    page = (folder / "report.html").read_text()
    assert "1 of 12 (2" in page
    assert page.index(f"<td>{LOST}<td>") < page.index("<td>pillars:0<td>")


def test_a_change_is_beside_the_main_comparison_and_says_what_it_saves(found):
    table, _ = found
    assert [each["ablation"] for each in table["changes"] if each["case"]["name"] == "l"] == [
        KNOWN_MAP,
        "a_max 3 m/s^2",
    ]
    assert gain(table, "l", "avoid", "a_max 3 m/s^2")["saved"]["pairs"] == 6
    assert gain(table, "l", "avoid", KNOWN_MAP)["saved"]["estimate"]["value"] == pytest.approx(20.0)
    saved = {cell["strategy"]: cell["saved_by_change"]["value"] for cell in case(table, "l", KNOWN_MAP)["cells"]}
    assert saved == {"bounce": pytest.approx(100.0 * (1 - 0.64 / 0.9)), "avoid": pytest.approx(20.0)}


def test_rebounds_are_compared_with_what_was_foreseen(found):
    rebounds = {each["strategy"]: each["rebounds"] for each in case(found[0], "l")["cells"]}
    ours = rebounds["bounce"]
    assert (ours["impacts"], ours["foreseen"], ours["deliberate"]) == (36, 24, 12)
    assert (ours["direction_error"], ours["deliberate_direction_error"]) == (pytest.approx(13.0), pytest.approx(6.0))
    assert ours["direction_error_p90"] == pytest.approx(20.0)
    assert (ours["speed_into"], ours["speed_error"]) == (pytest.approx(0.3), pytest.approx(-0.1))
    assert rebounds["avoid"]["direction_error"] is None


def test_a_smaller_one_is_asked_by_option_and_a_parameter_that_is_set_replaces_no_other():
    asked = parse(["--bounces", "--worlds", "u:0-3", "--trials", "1", "--no-ablations", "--seed", "1"]).question()
    assert (asked.worlds, asked.trials, asked.ablations, asked.seed) == (("u:0-3",), 1, False, 1)
    assert (asked.strategies, asked.values) == (DEFAULTS["strategies"], DEFAULTS["values"])
    given = ["--bounces", "--set", "simulator.friction_spread=0", "--set", "robot.max_acceleration=2"]
    asked = parse(given).question()
    expected = ("simulator.restitution_spread=0.08", "simulator.friction_spread=0", "robot.max_acceleration=2")
    assert asked.values == expected
    assert parse(["--resume", "x", *given]).question(asked) == asked
    with pytest.raises(StudyError, match="values"):
        parse(["--resume", "x", "--set", "simulator.friction_spread=1"]).question(asked)


def test_the_engine_is_asked_by_option_and_is_in_every_row(sources):
    asked = parse(["--bounces", "--engine", "mujoco", "--worlds", "l:0"]).question()
    grid = make_grid(asked, sources[:1], VARIANTS)
    assert {(task.labels["engine"], task.settings.simulator.engine) for task in grid} == {("mujoco", "mujoco")}
    assert {task.labels["engine"] for task in make_grid(ASKED, sources[:1])} == {"pymunk"}
    with pytest.raises(StudyError, match="engine"):
        parse(["--resume", "x", "--engine", "pymunk"]).question(asked)
