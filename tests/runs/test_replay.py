"""The program replay, over journals of trials and over messages of a recording."""

import json

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_core.replay.journal import CONTROLLER, PLANNER
from collplan_core.worlds import load_world
from collplan_ros.replay.main import main
from collplan_ros.run.writer import RECORDING
from made_recordings import MadeRecording, String
from omnipuck_sim.trial import run_trial

SAME, DIFFERENT, REFUSED, INTERRUPTED = 0, 1, 2, 3


@pytest.fixture(scope="module")
def journal(tmp_path_factory):
    path = tmp_path_factory.mktemp("runs") / "trial.jsonl"
    settings = Settings().with_values({"planner.strategy": "harness", "trial.timeout": 2.0})
    run_trial(load_world("corridor"), settings, 1, journal=path)
    return path


@pytest.fixture
def rows(journal):
    return [json.loads(line) for line in journal.read_text().splitlines()]


@pytest.fixture
def replay(tmp_path, capsys):
    """Replays a journal of these rows: exit code, what is printed, and what is said of an error."""

    def replay(rows, *options):
        path = tmp_path / "other.jsonl"
        path.write_text("".join(json.dumps(row) + "\n" for row in rows))
        code = main([str(path), *options])
        said = capsys.readouterr()
        return code, said.out, said.err

    return replay


def without(rows, of, *numbers):
    return [row for row in rows if row.get("of") != of or row["number"] not in numbers]


def test_a_trial_is_bit_equal_and_a_gap_and_a_missing_journal_are_said(rows, replay):
    code, said, _ = replay(rows)
    planner, controller = said.splitlines()
    assert (code, "plans bit-equal" in planner, "commands bit-equal" in controller) == (SAME, True, True)
    code, said, _ = replay(without(rows, CONTROLLER, 12))
    planner, controller = said.splitlines()
    assert (code, "gap" in planner, "a gap" in controller) == (INTERRUPTED, False, True)
    assert "1 line" in controller
    code, said, _ = replay(without(rows, CONTROLLER, *range(1000)))
    assert (code, "no journal" in said) == (SAME, True)


def test_the_journals_in_a_recording_are_replayed_as_those_of_a_file(rows, tmp_path, capsys):
    made = MadeRecording(tmp_path / RECORDING)
    for row in rows:
        made.write(f"/{row.get('of', PLANNER)}/journal", String(json.dumps(row)))
    made.file.finish()
    assert (main([str(tmp_path)]), capsys.readouterr().out.count("bit-equal")) == (SAME, 2)


def test_a_recording_that_is_cut_off_is_not_replayed_as_a_whole_one(rows, tmp_path, capsys):
    path = tmp_path / RECORDING
    made = MadeRecording(path)
    for row in rows:
        made.write(f"/{row.get('of', PLANNER)}/journal", String(json.dumps(row)))
        made.file.flush()
    made.file.finish()
    held = path.read_bytes()
    path.write_bytes(held[:-1])
    assert main([str(tmp_path)]) == INTERRUPTED
    assert "has no end, it is cut off after" in capsys.readouterr().out


def test_a_trials_journal_whose_last_line_is_cut_off_is_not_replayed_as_a_whole_one(journal, tmp_path, capsys):
    path = tmp_path / "trial.jsonl"
    path.write_bytes(journal.read_bytes()[:-30])
    assert main([str(path)]) == INTERRUPTED
    assert "its last line is cut off" in capsys.readouterr().out


def test_a_difference_is_shown_and_what_has_changed_since(rows, replay):
    for row in rows[1:3]:
        row["made_with"]["numpy"] = "0.9"
    ticks = [call for row in rows for call in row.get("calls", ()) if "command" in (call.get("result") or ())]
    ticks[-1]["result"]["command"]["yaw_rate"] = 9.0
    code, said, _ = replay(rows)
    assert code == DIFFERENT
    assert "then at " in said
    assert ".command.yaw_rate: 9.0 recorded" in said
    assert f"0.9 then, {np.__version__} now" in said


def test_what_is_no_journal_is_refused_in_one_line(rows, replay, tmp_path, capsys):
    rows[1]["settings"]["settings"]["planner.gone"] = 1.0
    code, _, said = replay(rows)
    assert (code, "planner.gone" in said) == (REFUSED, True)
    path = tmp_path / "odd.jsonl"
    for text, words in (
        ("", "holds no journal"),
        ("no JSON\n{}\n", "line 1: not JSON"),
        ('{"number": 0, "of": "planner", "format": 6}\n', "settings"),
    ):
        path.write_text(text)
        assert main([str(path)]) == REFUSED, text
        (line,) = capsys.readouterr().err.splitlines()
        assert line.startswith("replay: ")
        assert words in line
    (tmp_path / "empty").mkdir()
    for name, words in (("gone.mcap",) * 2, ("empty", "run.mcap")):
        assert main([str(tmp_path / name)]) == REFUSED, name
        assert words in capsys.readouterr().err
