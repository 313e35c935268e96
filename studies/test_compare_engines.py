"""Two studies of bounces that differ in the engine: their table, and what is no such pair."""

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from collplan_study.question.bounces import DEFAULTS, KNOWN_MAP, VARIANTS, variants_of
from collplan_study.question.question import question_from
from collplan_study.question.sources import load_sources
from collplan_study.tables.table_files import TABLE
from compare_engines import engine_comparisons, main
from fake_studies import fake_study, reached

OF_ENGINES = ("l:0-5", "u:0-5", "pillars:0-5")
RIGID = question_from({**DEFAULTS, "bounces": True, "worlds": OF_ENGINES, "seed": 5})
SOFT = replace(RIGID, engine="mujoco")
CHANGES = {name: VARIANTS[name] for name in ("", KNOWN_MAP, "rough ring, friction 0.5")}


@pytest.fixture(scope="module")
def of_engines():
    return load_sources(OF_ENGINES, None, None)


@pytest.fixture(scope="module")
def folders(tmp_path_factory, of_engines):
    """bounce saves 10 % by pymunk and 7 % by mujoco, less in each world by the same."""

    def times(task):
        world = np.random.default_rng(int(task.world.name.split(":")[1])).normal(0.0, 0.03)
        factor = {"pymunk": 0.9, "mujoco": 0.93}[task.labels["engine"]] + world
        return reached(3.0 * (factor if task.labels["strategy"] == "bounce" else 1.0))

    folder = tmp_path_factory.mktemp("engines")
    soft = {**CHANGES, "soft ring, 40 ms": variants_of("mujoco")["soft ring, 40 ms"]}
    return (
        fake_study(folder / "rigid", times, RIGID, of_engines, CHANGES),
        fake_study(folder / "soft", times, SOFT, of_engines, soft),
    )


def test_differences_are_paired_by_world_and_seed(folders):
    found = list(engine_comparisons(RIGID.strategies, *(pl.read_parquet(folder / TABLE) for folder in folders)))
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


def test_only_studies_that_differ_in_the_engine_are_compared(folders, tmp_path, of_engines, capsys):
    assert main([str(folder) for folder in folders]) == 0
    assert "| 12 | 24 | " in capsys.readouterr().out
    other = fake_study(tmp_path / "other", lambda task: reached(3.0), replace(SOFT, seed=6), of_engines)
    paper = fake_study(tmp_path / "paper", lambda task: reached(3.0), question_from({"worlds": ("corridor",)}))
    for pair, why in [
        ((folders[0], folders[0]), "engine pymunk"),
        ((folders[0], other), "seed is"),
        ((folders[0], paper), "of bounces"),
        ((folders[0], tmp_path / "none"), "read"),
    ]:
        assert main([str(folder) for folder in pair]) == 2
        assert why in capsys.readouterr().err
