"""The program replay, over journals of trials and over messages of a recording."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_core.replay.comparison import Interruption, compare
from collplan_core.replay.contents import value_of
from collplan_core.replay.journal import CONTROLLER, PLANNER
from collplan_core.worlds import load_world
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


@pytest.fixture
def rows(journal):
    """The lines of the journal, to be changed."""
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
    """The rows without some lines of a journal, whose scans and plans are kept: the other one refers to them too."""
    return [
        {"contents": row.get("contents", [])} if row.get("of") == of and row["number"] in numbers else row
        for row in rows
    ]


def test_a_trial_is_bit_equal_and_a_gap_and_a_missing_journal_are_said(rows, replay):
    code, said, _ = replay(rows)
    planner, controller = said.splitlines()
    assert (code, "plans bit-equal" in planner, "commands bit-equal" in controller) == (SAME, True, True)
    code, said, _ = replay(without(rows, CONTROLLER, 12))
    planner, controller = said.splitlines()
    assert (code, "gap" in planner, "then a gap after " in controller) == (INTERRUPTED, False, True)
    assert "1 line" in controller
    code, said, _ = replay(without(rows, CONTROLLER, *range(1000)))
    assert (code, said.splitlines()[1]) == (SAME, "controller: no journal")


def test_a_difference_is_shown_in_time_and_value_and_what_has_changed_since(rows, replay):
    plan = next(
        each["plan"]
        for row in rows
        for call in row.get("calls", ())
        for each in (call.get("came") if isinstance(call.get("came"), list) else ())
        if "plan" in each and each["plan"]["stamp"] > 1.0
    )
    then = plan["aim"][0]
    plan["aim"][0] = then + 1e-12
    for row in rows[1:3]:
        row["made_with"]["numpy"] = "0.9"
    code, said, _ = replay(rows)
    assert code == DIFFERENT
    assert "; then at " in said
    assert f".plan.aim[0]: {plan['aim'][0]!r} recorded, {then!r} replayed" in said
    assert f"numpy 0.9 then, {np.__version__} now" in said
    assert "python" not in said


def test_what_is_no_journal_is_refused_in_one_line(rows, replay, tmp_path, capsys):
    rows[1]["settings"]["settings"]["planner.gone"] = 1.0
    code, _, said = replay(rows)
    assert (code, "planner.gone" in said) == (REFUSED, True)
    path = tmp_path / "odd.jsonl"
    for text, words in (
        ("", "holds no journal"),
        ('{"trial": {}}\n', "holds no journal"),
        ("no JSON\n{}\n", "line 1: not JSON"),
        ("3\n", "line 1: got 3"),
        ('{"number": 0, "of": "planner", "format": 1}\n', "settings"),
        ('{"number": "one", "of": "planner"}\n', "got number 'one'"),
    ):
        path.write_text(text)
        assert main([str(path)]) == REFUSED, text
        (line,) = capsys.readouterr().err.splitlines()
        assert line.startswith("replay: ")
        assert words in line
    (tmp_path / "empty").mkdir()
    for name, words in (("gone.jsonl",) * 2, ("gone.mcap",) * 2, ("gone", "gone"), ("empty", "run.mcap")):
        assert main([str(tmp_path / name)]) == REFUSED, name
        assert words in capsys.readouterr().err


def test_another_strategy_is_printed_as_a_table_up_to_a_gap(rows, replay):
    code, said, _ = replay(rows, "--strategy", "bounce")
    head, columns, *table = said.splitlines()
    assert (code, head.split()) == (SAME, ["harness", "bounce"])
    assert columns.split() == ["t", "[s]", *2 * ["ends", "length", "left", "contact"]]
    times = [float(row.split()[0]) for row in table]
    assert len(times) >= 8
    assert (times[0], times) == (0.0, sorted(times))
    code, said, _ = replay(without(rows, PLANNER, 8), "--strategy", "low_risk")
    *_, last, end = said.splitlines()
    assert (code, end.startswith("ends at a gap")) == (INTERRUPTED, True)
    assert float(last.split()[0]) > 0.5
    with pytest.raises(SystemExit, match=str(REFUSED)):
        replay(rows, "--strategy", "teleport")


# ---- a recording


class FakeRecording:
    """The messages of a graph that did what a trial does: journals that refer to scans and plans, and these."""

    def __init__(self, rows) -> None:
        self.messages = []
        names = {PLANNER: "planner/journal", CONTROLLER: "controller/journal"}
        for row in rows[1:]:
            for content in row.pop("contents", ()):
                self.messages.append(message_of(content))
            self.messages.append((names[row["of"]], SimpleNamespace(data=json.dumps(row))))

    def read(self, path, topics):
        return ((topic, 0, message) for topic, message in self.messages if topic in topics)

    def compared(self):
        journals = journals_from_recording("run.mcap", self.read)
        return next(compare(PLANNER, journals.events(PLANNER), journals.contents))


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


def test_scans_are_found_among_the_messages_one_that_is_none_is_passed_over_and_a_missing_one_is_a_gap(rows):
    recording = FakeRecording(rows)
    places = [k for k, (topic, _) in enumerate(recording.messages) if topic == "scan"]
    scan = recording.messages[places[0]][1]
    odd = [("scan", SimpleNamespace(**{**vars(scan), "ranges": []}))]
    odd.append(("plan", SimpleNamespace(header=scan.header, poses=[])))
    missing = recording.messages.pop(places[10])
    assert isinstance(recording.compared().end, Interruption)
    recording.messages = [*odd, *recording.messages, missing]
    found = recording.compared()
    assert found.end is None
    assert found.plans >= 8
