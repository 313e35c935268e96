"""The study's command line, and what it refuses before any trial."""

import json

import pytest

from collplan_study.main import main
from collplan_study.question.options import parse
from collplan_study.question.question import Question, question_from
from collplan_study.tables.columns import MEASURES, SHARES, columns
from study_runs import paths, table

ONE = ["--strategies", "harness", "--map-periods", "0.2", "--trials", "1", "--jobs", "1", "--no-report"]


def test_nothing_given_is_the_papers_question():
    assert parse([]).question() == Question()


def test_a_question_outlives_json():
    given = ["--worlds", "corridor,random:0-3", "--map-periods", "0.2,1", "--set", "a.b=1", "--set", "e.f=x,y"]
    question = parse([*given, "--start", "1", "2", "--seed", "5"]).question()
    assert question.worlds == ("corridor", "random:0-3")
    assert question.map_periods == (0.2, 1.0)
    assert question.values == ("a.b=1", "e.f=x,y")
    assert question.start == (1.0, 2.0)
    assert question_from(json.loads(json.dumps(question.record()))) == question


def test_ablations_ask_less_where_nothing_is_said():
    asked = parse(["--ablations"]).question()
    assert asked.ablations
    assert asked.map_periods == (0.2,)
    assert parse(["--ablations", "--map-periods", "0.4"]).question().map_periods == (0.4,)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--worlds", "corridr"], "did you mean corridor"),
        (["--strategies", "fast"], "planner.strategy: got 'fast', expected one of harness"),
        (["--set", "planner.map_perid=1"], "planner.map_perid: unknown parameter, did you mean planner.map_period"),
        (["--trials", "0"], "--trials: got 0, expected at least 1"),
        (["--jobs", "0"], "--jobs: got 0"),
        (["--worlds", "random:5-4"], "random:5-4"),
        (["--goal", "nan", "0"], "nan"),
        (["--resume", "nowhere"], "nowhere/provenance.json"),
    ],
)
def test_a_bad_option_is_one_line_and_exit_code_2(tmp_path, monkeypatch, capsys, arguments, expected):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith("study: ")
    assert len(error.splitlines()) == 1
    assert expected in error
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "arguments",
    [
        ["--trials", "x"],
        ["--worlds"],
        ["--worlds", "corridor,,slalom"],
        ["--map-periods", "0.2,x"],
        ["--goal", "1"],
        ["--speed", "3"],
    ],
)
def test_what_no_option_can_be_is_refused_by_the_parser(capsys, arguments):
    with pytest.raises(SystemExit, match="2"):
        main(arguments)
    assert arguments[0] in capsys.readouterr().err


def test_a_folder_in_use_is_left_alone(tmp_path, capsys):
    study, other, file = tmp_path / "study", tmp_path / "other", tmp_path / "file"
    assert main([*ONE, "--out", str(study)]) == 0
    other.mkdir()
    (other / "mine.txt").write_text("mine")
    file.write_text("mine")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    for path, expected in (
        (study, f"holds a study already, continue it with --resume {study}"),
        (other, "expected a new or an empty folder"),
        (file, "expected a new or an empty folder"),
        (file / "deeper", "cannot be written"),
    ):
        capsys.readouterr()
        assert main([*ONE, "--out", str(path)]) == 2
        assert expected in capsys.readouterr().err
    assert main([*ONE, "--out", str(study), "--resume", str(study)]) == 2
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_what_a_study_leaves(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*ONE, "--set", "planner.position_pruning=true,false", "--set", "robot.max_acceleration=2"]) == 0
    (folder,) = (tmp_path / "runs").iterdir()
    assert folder.name.startswith("study-")
    first, second = table(folder).to_pylist()
    axes = ("planner.position_pruning", "robot.max_acceleration")
    assert [(row[axes[0]], row[axes[1]]) for row in (first, second)] == [(True, 2.0), (False, 2.0)]
    assert (first["outcome"], first["family"], first["ablation"], first["error"]) == ("reached", "corridor", "", "")
    assert sum(first[share] for share in SHARES) == pytest.approx(1.0)
    assert first["path_length_m"] / first["arrival_time_s"] == pytest.approx(first["mean_speed"])
    assert first["unforeseen_impacts"] + first["deliberate_impacts"] <= first["impacts"]
    text = (folder / "trials.csv").read_text().splitlines()
    assert text[0].split(",") == list(columns(axes))
    assert set(MEASURES) < set(columns(axes))
    assert text[1].startswith("corridor,corridor,,pymunk,harness,0.2,true,2.0,0,")
    assert f"{folder.relative_to(tmp_path)}: 2 trials (simulated): 2 reached" in capsys.readouterr().out


def test_provenance_says_where_numbers_come_from(tmp_path):
    folder = tmp_path / "study"
    assert main([*ONE, "--out", str(folder)]) == 0
    assert main(["--resume", str(folder), "--no-report", "--jobs", "1"]) == 0
    provenance = json.loads((folder / "provenance.json").read_text())
    assert provenance["results"] == "simulated"
    assert provenance["parameters"]["robot.max_acceleration"] == 1.5
    assert {"numpy", "numba", "pymunk", "collplan-core"} <= set(provenance["versions"])
    assert len(provenance["code"]["trial"]) == 16
    assert [session["trials"] for session in provenance["sessions"]] == [1, 0]
    assert all(session["ended"] >= session["begun"] for session in provenance["sessions"])


def test_paths_are_kept_at_20_hz_to_the_tenth_of_a_millimetre(tmp_path):
    folder = tmp_path / "study"
    assert main([*ONE, "--out", str(folder)]) == 0
    (row,), (path,) = table(folder).to_pylist(), paths(folder).to_pylist()
    assert path["strategy"] == "harness"
    assert len(path["t"]) == len(path["x"]) == len(path["y"])
    steps = [b - a for a, b in zip(path["t"], path["t"][1:], strict=False)]
    assert max(steps) == pytest.approx(0.05, abs=1e-3)
    assert len(steps) == pytest.approx(20.0 * row["arrival_time_s"], abs=2)
    assert path["t"][-1] == pytest.approx(row["arrival_time_s"], abs=1e-3)
    length = sum(
        ((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5
        for x0, y0, x1, y1 in zip(path["x"], path["y"], path["x"][1:], path["y"][1:], strict=False)
    )
    assert length == pytest.approx(row["path_length_m"], rel=0.01)
