"""The command `optimum`: what it runs, what it compares, what it leaves; times and optima are made up."""

import csv
import json
import math

import pytest

from collplan_study.analysis import statistics
from collplan_study.question import held_out
from collplan_study.question.question import parse as parse_study
from collplan_study.question.question import question_from
from collplan_study.question.specification import DEFAULTS, KNOWN_MAP, SPREADS, VARIANTS
from fake_studies import fake_study, reached
from optimum import __main__ as command
from optimum.__main__ import main
from optimum.options import FAMILIES, STUDY, parse
from optimum.world_optimum import WorldOptimum

OPTIMUM = 3.0
FACTORS = {"bounce": 0.9, "avoid": 1.2}
VARIANT = {name: VARIANTS[name] for name in ("", KNOWN_MAP)}


def question(*worlds: str, values=SPREADS):
    strategies = ("bounce", "avoid")
    return question_from(
        {**DEFAULTS, "bounces": True, "worlds": worlds, "strategies": strategies, "values": values, "seed": 5}
    )


def seed_of(world: str) -> int:
    return int(world.split(":")[1])


def run(task):
    """A percent slower in each further world, a tenth to and fro by trial, and much faster in a variant."""
    factor = FACTORS[task.labels["strategy"]] + 0.01 * seed_of(task.world.name) + (-0.1, 0.1)[task.labels["trial"]]
    return reached(OPTIMUM * (0.1 if task.labels["ablation"] else factor))


def made_up(world, disc):
    return WorldOptimum(world.name, OPTIMUM, 0.75 * OPTIMUM, 2, 1e-4 * seed_of(world.name))


@pytest.fixture(autouse=True)
def _quick(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(statistics, "RESAMPLES", 199)
    monkeypatch.setattr(command, "check_installed", lambda: None)
    monkeypatch.setattr(command, "world_optimum", made_up)


@pytest.fixture
def ratios(tmp_path):
    return lambda: json.loads((tmp_path / "runs/optimum.json").read_text())


def test_ratios_are_means_over_worlds_with_their_interval(tmp_path, ratios, capsys):
    folder = fake_study(tmp_path / "study", run, question("u:0-5", "pillars:0"), ablations=VARIANT)
    assert main(["--of", str(folder), "--jobs", "1"]) == 0
    assert ratios().keys() == {"u"}
    for strategy, factor in FACTORS.items():
        found = ratios()["u"][strategy]
        assert (found["ratio"], found["worlds"]) == (pytest.approx(factor + 0.025), 6)
        assert factor < found["low"] < found["ratio"] < found["high"] < factor + 0.05

    said = capsys.readouterr().out
    assert all(part in said for part in ("| u | 6 | 3.000 | 0.750", "0.925 [", "], 6 of 6", "0.050 %", "pillars"))
    with (folder / "optimum.csv").open() as file:
        rows = [(row["world"], float(row["time"]), float(row["bound"])) for row in csv.DictReader(file)]
    assert rows == [(f"u:{seed}", 3.0, 2.25) for seed in range(6)]


def test_a_world_without_a_trajectory_is_left_out_and_named(tmp_path, ratios, monkeypatch, capsys):
    def unsolved(world, disc):
        return WorldOptimum("u:3", math.nan, 1.0, 0, math.nan) if world.name == "u:3" else made_up(world, disc)

    monkeypatch.setattr(command, "world_optimum", unsolved)
    folder = fake_study(tmp_path / "study", run, question("u:0-5"))
    assert main(["--of", str(folder), "--jobs", "1"]) == 1
    assert ratios()["u"]["bounce"]["worlds"] == 5
    assert ratios()["u"]["bounce"]["ratio"] == pytest.approx(0.9 + 0.01 * (0 + 1 + 2 + 4 + 5) / 5)
    assert "u:3" in capsys.readouterr().err


def test_what_cannot_be_compared_is_refused(tmp_path, capsys):
    pillars = fake_study(tmp_path / "pillars", run, question("pillars:0"))
    paper = fake_study(tmp_path / "paper", lambda task: reached(3.0), question_from({"worlds": ("corridor",)}))
    for options, why in [
        (["--of", str(pillars)], "pillars"),
        (["--of", str(paper)], "bounces"),
        (["--of", str(tmp_path / "none")], "read"),
        (["--of", str(pillars), "--trials", "1"], "but --jobs"),
        (["--jobs", "0"], "--jobs: got"),
    ]:
        assert main(options) == 2
        assert why in capsys.readouterr().err


def test_its_own_worlds_and_noise_are_held_out_and_options_of_study_replace_its_own():
    asked = parse_study(STUDY).question()
    assert (asked.strategies, asked.trials, asked.ablations, asked.values) == (("bounce", "avoid"), 2, False, SPREADS)
    assert asked.seed not in (held_out.STUDY_SEED, 61)
    for world, family in zip(asked.worlds, FAMILIES, strict=True):
        first, last = map(int, world.removeprefix(f"{family}:").split("-"))
        assert last - first == 23
        assert last < held_out.FIRST_SEED or first > held_out.LAST_SEED
    options = parse(["--worlds", "u:0-3", "--set", "simulator.noise=0", "--jobs", "1"])
    asked = parse_study(options.study)
    assert (asked.out, asked.jobs, asked.question().worlds) == (options.folder, 1, ("u:0-3",))
    assert asked.question().values == (*SPREADS, "simulator.noise=0")
