"""The program replay, over journals of trials and over messages of a recording."""

import json
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_core.replay.comparison import Interruption, compare
from collplan_core.replay.contents import value_of
from collplan_core.replay.journal import CONTROLLER, PLANNER
from collplan_core.worlds import load_world
from collplan_ros.replay import main as program
from collplan_ros.replay.main import main
from collplan_ros.replay.recorded_journals import journals_from_recording
from omnipuck_sim.trial import run_trial

SAME, DIFFERENT, REFUSED, INTERRUPTED = 0, 1, 2, 3


@pytest.fixture(scope="module")
def journal(tmp_path_factory):
    path = tmp_path_factory.mktemp("runs") / "trial.jsonl"
    settings = Settings().with_values({"planner.strategy": "harness", "trial.timeout": 2.0})
    run_trial(load_world("corridor"), settings, 1, journal=path)
    return path


def lines_of(path) -> list[dict]:
    return [json.loads(line) for line in path.read_text().splitlines()]


def without(rows, of, *numbers) -> list[dict]:
    """The rows without some lines of a journal, whose scans and plans are kept: the other one refers to them too."""
    return [
        {"contents": row.get("contents", [])} if row.get("of") == of and row["number"] in numbers else row
        for row in rows
    ]


def written(path, rows):
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    return str(path)


# ---- a trial's journal


def test_a_trial_is_bit_equal(journal, capsys):
    assert main([str(journal)]) == SAME
    planner, controller = capsys.readouterr().out.splitlines()
    assert planner.startswith("planner: ")
    assert "plans bit-equal, from " in planner
    assert controller.startswith("controller: ")
    assert "commands bit-equal, from " in controller


def test_a_difference_is_shown_in_time_and_value(journal, tmp_path, capsys):
    rows = lines_of(journal)
    plan = next(
        each["plan"]
        for row in rows
        for call in row.get("calls", ())
        for each in (call.get("came") if isinstance(call.get("came"), list) else ())
        if "plan" in each and each["plan"]["stamp"] > 1.0
    )
    then = plan["aim"][0]
    plan["aim"][0] = then + 1e-12
    assert main([written(tmp_path / "other.jsonl", rows)]) == DIFFERENT
    said = capsys.readouterr().out
    assert "; then at " in said
    assert f".plan.aim[0]: {plan['aim'][0]!r} recorded, {then!r} replayed" in said


def test_what_has_changed_since_is_said_with_a_difference(journal, tmp_path, capsys):
    rows = lines_of(journal)
    for row in rows[1:3]:
        row["made_with"]["numpy"] = "0.9"
        row["settings"]["settings"]["robot.max_speed"] = 1.1
    assert main([written(tmp_path / "other.jsonl", rows)]) == DIFFERENT
    said = capsys.readouterr().out
    assert f"  numpy 0.9 then, {np.__version__} now" in said
    assert "python" not in said


def test_a_gap_is_said(journal, tmp_path, capsys):
    rows = without(lines_of(journal), CONTROLLER, 12)
    assert main([written(tmp_path / "other.jsonl", rows)]) == INTERRUPTED
    planner, controller = capsys.readouterr().out.splitlines()
    assert "gap" not in planner
    assert "; then a gap after " in controller
    assert controller.endswith("1 line is missing before line 13 of the journal")


def test_one_loop_without_a_journal_is_said(journal, tmp_path, capsys):
    rows = without(lines_of(journal), CONTROLLER, *range(1000))
    assert main([written(tmp_path / "other.jsonl", rows)]) == SAME
    assert capsys.readouterr().out.splitlines()[1] == "controller: no journal"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "holds no journal"),
        ('{"trial": {}}\n', "holds no journal"),
        ("no JSON\n{}\n", "line 1: not JSON"),
        ("3\n", "line 1: got 3, expected an object"),
        ('{"number": 0, "of": "planner", "format": 1}\n', "settings"),
        ('{"number": "one", "of": "planner"}\n', "got number 'one'"),
    ],
)
def test_what_is_no_journal_is_refused(tmp_path, capsys, text, words):
    path = tmp_path / "odd.jsonl"
    path.write_text(text)
    assert main([str(path)]) == REFUSED
    said = capsys.readouterr().err
    assert said.startswith("replay: ")
    assert words in said
    assert len(said.splitlines()) == 1


def test_a_parameter_that_is_not_known_here_is_named(journal, tmp_path, capsys):
    rows = lines_of(journal)
    rows[1]["settings"]["settings"]["planner.gone"] = 1.0
    assert main([written(tmp_path / "other.jsonl", rows)]) == REFUSED
    assert "planner.gone" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["gone.jsonl", "gone.mcap", "gone"])
def test_what_is_not_there_is_refused(tmp_path, capsys, name):
    assert main([str(tmp_path / name)]) == REFUSED
    assert name in capsys.readouterr().err


def test_a_folder_without_a_recording_is_refused(tmp_path, capsys):
    assert main([str(tmp_path)]) == REFUSED
    assert "run.mcap" in capsys.readouterr().err


def test_another_strategy_is_printed_as_a_table(journal, capsys):
    assert main([str(journal), "--strategy", "bounce"]) == SAME
    head, columns, *rows = capsys.readouterr().out.splitlines()
    assert head.split() == ["harness", "bounce"]
    assert columns.split() == ["t", "[s]", *2 * ["ends", "length", "left", "contact"]]
    assert len(rows) >= 8
    assert rows[0].startswith("0.000 ")
    times = [float(row.split()[0]) for row in rows]
    assert times == sorted(times)


def test_a_table_that_ends_at_a_gap_says_so(journal, tmp_path, capsys):
    path = written(tmp_path / "other.jsonl", without(lines_of(journal), PLANNER, 8))
    assert main([path, "--strategy", "low_risk"]) == INTERRUPTED
    *_, last, end = capsys.readouterr().out.splitlines()
    assert float(last.split()[0]) > 0.5
    assert end == "ends at a gap: 1 line is missing before line 9 of the journal"


def test_a_strategy_that_there_is_not_is_refused(journal, capsys):
    with pytest.raises(SystemExit) as ended:
        main([str(journal), "--strategy", "teleport"])
    assert ended.value.code == REFUSED
    assert "teleport" in capsys.readouterr().err


def test_a_reader_that_goes_away_ends_nothing(journal):
    program = [sys.executable, "-m", "collplan_ros.replay.main", str(journal), "--strategy", "low_risk"]
    replay = subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    replay.stdout.close()
    assert replay.stderr.read() == b""
    assert replay.wait(100.0) == SAME


def test_finishing_is_left_to_the_recording(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(program, "complete", lambda folder: f"{folder.name}: 3 files made")
    assert main(["--finish", str(tmp_path / "killed")]) == SAME
    assert capsys.readouterr().out == "killed: 3 files made\n"


# ---- a recording


class FakeRecording:
    """The messages of a graph that did what a trial does: journals that refer to scans and plans, and these."""

    def __init__(self, journal) -> None:
        self.messages = []
        names = {PLANNER: "planner/journal", CONTROLLER: "controller/journal"}
        for row in lines_of(journal)[1:]:
            for content in row.pop("contents", ()):
                self.messages.append(message_of(content))
            self.messages.append((names[row["of"]], SimpleNamespace(data=json.dumps(row))))

    def read(self, path, topics):
        return ((topic, 0, message) for topic, message in self.messages if topic in topics)

    def compared(self, of):
        journals = journals_from_recording("run.mcap", self.read)
        return next(compare(of, journals.events(of), journals.contents))


def message_of(content):
    """A topic and what a message of a scan or a plan has for attributes; stamps of a trial are whole nanoseconds."""
    value = value_of(content)

    def head(stamp, frame):
        # all of it in nanoseconds: a sum of two rounded parts may be another number
        return SimpleNamespace(frame_id=frame, stamp=SimpleNamespace(sec=0, nanosec=round(1e9 * stamp)))

    if "scan" in content:
        last = value.angle_min + value.angle_increment * (len(value.ranges) - 1)
        fields = {name: getattr(value, name) for name in ("angle_min", "angle_increment", "time_increment")}
        limits = {"range_min": value.range_min, "range_max": value.range_max, "scan_time": 0.0}
        limits["ranges"] = value.ranges.tolist()
        return "scan", SimpleNamespace(header=head(value.stamp, "base_link"), angle_max=last, **fields, **limits)
    poses = [
        SimpleNamespace(header=head(time, "map"), pose=SimpleNamespace(position=SimpleNamespace(x=x, y=y)))
        for time, (x, y) in zip(value.times.tolist(), value.positions.tolist(), strict=True)
    ]
    return "plan", SimpleNamespace(header=head(value.stamp, "map"), poses=poses)


def test_scans_are_found_among_the_messages(journal):
    recording = FakeRecording(journal)
    found = recording.compared(PLANNER)
    assert found.end is None
    assert found.plans >= 8


def test_a_scan_that_was_not_recorded_is_a_gap(journal):
    recording = FakeRecording(journal)
    places = [k for k, (topic, _) in enumerate(recording.messages) if topic == "scan"]
    del recording.messages[places[10]]
    found = recording.compared(PLANNER)
    assert isinstance(found.end, Interruption)
    assert "is not in the recording" in str(found.end)


def test_a_message_that_is_no_scan_is_passed_over(journal):
    recording = FakeRecording(journal)
    scan = next(message for topic, message in recording.messages if topic == "scan")
    recording.messages.insert(0, ("scan", SimpleNamespace(**{**vars(scan), "ranges": []})))
    recording.messages.insert(0, ("plan", SimpleNamespace(header=scan.header, poses=[])))
    assert recording.compared(PLANNER).end is None
