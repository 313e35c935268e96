"""Worlds of BARN as world files, and BARN's score."""

import json

import numpy as np
import pytest

from barn import main, optimal_lengths
from collplan_core.worlds import read_world
from collplan_study.question.grid import load_sources
from collplan_study.question.question import Question
from fake_studies import fake_study, reached
from sdf_files import CYLINDER, model, write


def test_barn_is_converted_and_scored(tmp_path, capsys):
    data, worlds = tmp_path / "data", tmp_path / "barn"
    data.mkdir()
    for name in ("world_10.world", "world_9.world.gz"):
        write(data, model(CYLINDER, at="-2 6 0 0 0 0"), name=name)
    assert main(["worlds", str(data), "--out", str(worlds), "--scale", "0.5"]) == 0
    world = read_world(worlds / "world_9.yaml")
    assert (world.name, world.goal.tolist()) == ("barn:9", [-1.125, 6.5])
    (data / "path_files").mkdir()
    # straight up the column of cells right of the start: from -4.575 + 16 * 0.15 = -2.175
    np.save(data / "path_files" / "path_10.npy", np.array([[16, 0], [16, 20]]))
    expected = np.hypot(0.075, 2.075) + 20 * 0.15 + np.hypot(0.075, 13.0 - 8.075)
    assert optimal_lengths(data) == {"barn:10": pytest.approx(expected)}
    (data / "path_length_m.json").write_text(json.dumps({"9": 20.0, "10": 20.0}))

    def touches_in_one(task):
        return reached(12.0, impacts=int(task.world.name == "barn:10"))

    question = Question((str(worlds),), ("harness",), map_periods=(0.2,), trials=1)
    study = fake_study(tmp_path / "study", touches_in_one, question, load_sources(question.worlds, None, None))
    capsys.readouterr()
    assert main(["score", str(study), str(data), "--scale", "0.5"]) == 0
    few, said = "(2 of 5 needed for an interval)", capsys.readouterr().out
    assert "| score | untouched | score, first touch ends the run |" in said
    assert f"| harness | 2 | 2 | 2.40 | {5 / 12:.3f} {few} | 1 | {5 / 24:.3f} {few} |" in said
