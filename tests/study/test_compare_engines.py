"""Two studies of bounces that differ in the engine: which can be run, and what their comparison says."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from collplan_study.analysis import statistics
from collplan_study.analysis.engine_comparisons import engine_comparisons
from collplan_study.analysis.rows import read_rows
from collplan_study.compare_engines import main
from collplan_study.errors import StudyError
from collplan_study.main import main as study
from collplan_study.question.bounces import DEFAULTS, KNOWN_MAP, VARIANTS, variants_of
from collplan_study.question.grid import make_grid
from collplan_study.question.options import parse
from collplan_study.question.question import question_from
from collplan_study.question.sources import load_sources
from collplan_study.tables.table_files import TABLE
from fake_studies import fake_study, reached

WORLDS = ("l:0-5", "u:0-5", "pillars:0-5")
RIGID = question_from({**DEFAULTS, "bounces": True, "worlds": WORLDS, "seed": 5})
SOFT = replace(RIGID, engine="mujoco")
SOME = {name: VARIANTS[name] for name in ("", KNOWN_MAP, "rough ring, friction 0.5")}


@pytest.fixture(scope="module")
def sources():
    return load_sources(WORLDS, None, None)


@pytest.fixture(scope="module")
def folders(tmp_path_factory, sources):
    """bounce saves 10 % by pymunk and 7 % by mujoco, less in each world by the same."""

    def times(task):
        world = np.random.default_rng(int(task.world.name.split(":")[1])).normal(0.0, 0.03)
        factor = {"pymunk": 0.9, "mujoco": 0.93}[task.labels["engine"]] + world
        return reached(3.0 * (factor if task.labels["strategy"] == "bounce" else 1.0))

    folder = tmp_path_factory.mktemp("engines")
    soft = {**SOME, "soft ring, 40 ms": variants_of("mujoco")["soft ring, 40 ms"]}
    return (
        fake_study(folder / "rigid", times, RIGID, sources, SOME),
        fake_study(folder / "soft", times, SOFT, sources, soft),
    )


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(statistics, "RESAMPLES", 199)


def test_differences_are_paired_by_world_and_seed(folders):
    found = list(engine_comparisons(RIGID.strategies, *(read_rows(folder / TABLE) for folder in folders)))
    first = found[0]
    assert (first.group.name, first.ablation) == ("2 families together", "")
    assert (first.worlds, first.pairs) == (12, 24)
    assert first.first.value - first.second.value == pytest.approx(3.0)
    assert first.first.high - first.first.low > 0.5
    # what differs from world to world is the same in both
    assert first.difference.value == pytest.approx(-3.0)
    assert [each.group.name for each in found if not each.ablation] == ["2 families together", "l", "u", "pillars"]
    assert [each.group.name for each in found if "rough" in each.ablation] == ["2 families together", "pillars"]
    (soft, _) = (each for each in found if each.ablation == "soft ring, 40 ms")
    assert (soft.first.value, soft.difference.value, soft.worlds) == (None, None, 12)
    assert soft.second.low < soft.second.value < soft.second.high


def test_the_table_names_engines_changes_and_numbers(folders, capsys):
    assert main([str(folder) for folder in folders]) == 0
    lines = capsys.readouterr().out.splitlines()
    head, _, first, *_ = (line for line in lines if line.startswith("|"))
    assert ("pymunk" in head, "mujoco" in head) == (True, True)
    assert "| 12 | 24 | " in first
    assert not any(KNOWN_MAP in line for line in lines)


def test_studies_that_differ_in_more_or_in_nothing_are_refused(folders, tmp_path, sources, capsys):
    other = fake_study(tmp_path / "other", lambda task: reached(3.0), replace(SOFT, seed=6), sources)
    paper = fake_study(tmp_path / "paper", lambda task: reached(3.0), question_from({"worlds": ("corridor",)}))
    for pair, why in [
        ((folders[0], folders[0]), "engine pymunk"),
        ((folders[0], other), "seed is"),
        ((folders[0], paper), "of bounces"),
        ((folders[0], tmp_path / "none"), "read"),
    ]:
        assert main([str(folder) for folder in pair]) == 2
        assert why in capsys.readouterr().err


def test_the_engine_is_asked_by_option_and_is_in_every_row(sources):
    asked = parse(["--bounces", "--engine", "mujoco", "--worlds", "l:0"]).question()
    grid = make_grid(asked, sources[:1], VARIANTS)
    assert {(task.labels["engine"], task.settings.simulator.engine) for task in grid} == {("mujoco", "mujoco")}
    assert {task.labels["engine"] for task in make_grid(RIGID, sources[:1])} == {"pymunk"}
    with pytest.raises(StudyError, match="engine"):
        parse(["--resume", "x", "--engine", "pymunk"]).question(asked)


def test_other_ways_to_name_an_engine_and_one_that_is_not_installed_stop_the_study(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    for options, why in [
        (["--engine", "bullet"], "'bullet'"),
        (["--set", "simulator.engine=mujoco"], "--engine"),
        (["--engine", "mujoco"], "mujoco-core"),
    ]:
        assert study([*options, "--trials", "1", "--out", str(tmp_path / "study")]) == 2
        assert why in capsys.readouterr().err
        assert not (tmp_path / "study").exists()
