"""The study's command line, what it refuses before any trial, and what it leaves."""

import json
from dataclasses import asdict
from itertools import pairwise
from math import dist

import pytest

from collplan_study.main import main
from collplan_study.question.question import Question, parse, question_from
from collplan_study.run.rows import MEASURES, SHARES, columns
from study_runs import WALL_TIMES, paths, table

ONE = ["--strategies", "harness", "--map-periods", "0.2", "--trials", "1", "--jobs", "1", "--no-report"]
AXES = ("planner.position_pruning", "robot.max_acceleration")


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "study"
    assert main([*ONE, "--set", f"{AXES[0]}=true,false", "--set", f"{AXES[1]}=2", "--out", str(folder)]) == 0
    assert main(["--resume", str(folder), "--no-report", "--jobs", "1"]) == 0
    return folder


def test_a_question_outlives_json_and_nothing_given_is_the_papers():
    assert parse([]).question() == Question()
    given = ["--worlds", "corridor,random:0-3", "--map-periods", "0.2,1", "--set", "a.b=1", "--set", "e.f=x,y"]
    question = parse([*given, "--start", "1", "2", "--seed", "5"]).question()
    assert (question.worlds, question.map_periods) == (("corridor", "random:0-3"), (0.2, 1.0))
    assert (question.values, question.start) == (("a.b=1", "e.f=x,y"), (1.0, 2.0))
    assert question_from(json.loads(json.dumps(asdict(question)))) == question
    asked = [parse(["--ablations", *more]).question() for more in ((), ("--map-periods", "0.4"))]
    assert [(each.ablations, each.map_periods) for each in asked] == [(True, (0.2,)), (True, (0.4,))]


def test_a_bad_option_is_one_line_and_exit_code_2(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for arguments, expected in [
        (["--worlds", "corridr"], "corridor"),
        (["--jobs", "0"], "--jobs: got"),
        (["--goal", "nan", "0"], "nan"),
        (["--resume", "nowhere"], "nowhere/provenance.json"),
    ]:
        assert main(arguments) == 2
        error = capsys.readouterr().err
        assert error.startswith("study: ")
        assert len(error.splitlines()) == 1
        assert expected in error
        assert list(tmp_path.iterdir()) == []


def test_a_folder_in_use_is_left_alone(study, tmp_path, capsys):
    other, file = tmp_path / "other", tmp_path / "file"
    other.mkdir()
    (other / "mine.txt").write_text("mine")
    file.write_text("mine")

    def contents():
        return {path: path.read_bytes() for root in (tmp_path, study) for path in root.rglob("*") if path.is_file()}

    before = contents()
    for path, expected in ((study, "--resume"), (other, "empty"), (file, "empty"), (file / "x", "Not a directory")):
        assert main([*ONE, "--out", str(path)]) == 2
        assert expected in capsys.readouterr().err
    assert main([*ONE, "--out", str(study), "--resume", str(study)]) == 2
    assert contents() == before


def test_what_a_study_leaves(study):
    first, second = table(study).to_dicts()
    assert [(row[AXES[0]], row[AXES[1]]) for row in (first, second)] == [(True, 2.0), (False, 2.0)]
    assert (first["outcome"], first["family"], first["ablation"], first["error"]) == ("reached", "corridor", "", "")
    assert sum(first[share] for share in SHARES) == pytest.approx(1.0)
    assert first["path_length_m"] / first["arrival_time_s"] == pytest.approx(first["mean_speed"])
    assert first["unforeseen_impacts"] + first["deliberate_impacts"] <= first["impacts"]
    assert list(first) == [name for name in columns(AXES) if name not in WALL_TIMES]
    assert set(MEASURES) < set(columns(AXES))
    # where numbers come from
    provenance = json.loads((study / "provenance.json").read_text())
    assert provenance["results"] == "simulated"
    assert provenance["parameters"]["robot.max_acceleration"] == 1.5
    assert {"numpy", "numba", "pymunk", "collplan-core"} <= set(provenance["versions"])
    assert [session["done_before"] for session in provenance["sessions"]] == [0, 2]


def test_paths_are_kept_at_20_hz_to_the_tenth_of_a_millimetre(study):
    row, path = table(study).to_dicts()[0], paths(study).to_dicts()[0]
    assert path["strategy"] == "harness"
    assert len(path["t"]) == len(path["x"]) == len(path["y"])
    steps = [b - a for a, b in pairwise(path["t"])]
    assert max(steps) == pytest.approx(0.05, abs=1e-3)
    assert len(steps) == pytest.approx(20.0 * row["arrival_time_s"], abs=2)
    assert path["t"][-1] == pytest.approx(row["arrival_time_s"], abs=1e-3)
    length = sum(dist(a, b) for a, b in pairwise(zip(path["x"], path["y"], strict=True)))
    assert length == pytest.approx(row["path_length_m"], rel=0.01)
