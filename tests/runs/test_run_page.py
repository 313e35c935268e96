"""run.html: what is in it is what was recorded, it needs nothing but itself, and what cannot be read is refused."""

import base64
import hashlib
from html.parser import HTMLParser

import numpy as np
import pytest

from collplan_ros.replay.main import main
from collplan_ros.run.page import write_run_page
from collplan_ros.run.page.run_frames import thinned
from collplan_ros.run.run_log import PoseRow, RunLog
from collplan_ros.run.whole_file import RunError
from collplan_ros.run.writer import RECORDING
from made_runs import EPOCH, HIT_AT, THOUGHT, WALL, bouncing_run
from played_folders import newest, played_folder, poses_in, recording_in

ZERO = 0.15
"""When the first command moves the robot of `bouncing_run` [s]."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return played_folder(tmp_path_factory.mktemp("runs"))


@pytest.fixture(scope="module")
def page(folder):
    return write_run_page(folder).read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def frames(page):
    return recording_in(page)["frames"]


def one_pose():
    return RunLog(poses=bouncing_run().poses[:1])


class Parsed(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.elements = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs), []))

    def handle_data(self, data):
        if self.elements:
            self.elements[-1][2].append(data)

    def text(self, tag, **attributes):
        (text,) = (text for name, own, text in self.elements if name == tag and attributes.items() <= own.items())
        return text[0]


# ---- what is in it


def test_every_pose_is_in_it_and_times_are_those_of_the_other_files(frames):
    log = bouncing_run()
    assert log.begin == pytest.approx(EPOCH + ZERO)
    assert frames[0]["t"] == pytest.approx(-ZERO)
    expected = np.array([[1e3 * (pose.stamp - log.begin), 1e3 * pose.x, 1e3 * pose.y] for pose in log.poses])
    np.testing.assert_allclose(poses_in(frames), expected, atol=1.01)


def test_every_plan_is_shown_from_when_it_was_sent(frames):
    shown = [frame for frame in frames if frame.get("plan")]
    stamps = [frame["plan"]["stamp"] for frame in shown]
    assert stamps == pytest.approx([stamp - EPOCH - ZERO for stamp in bouncing_run().plans], abs=2e-3)
    assert [frame["t"] - frame["plan"]["stamp"] for frame in shown] == pytest.approx([THOUGHT] * len(shown), abs=0.011)
    first = shown[0]["plan"]
    assert first["times"] == [0, 1000]
    x, y, vx, vy, after = first["contacts"]
    assert (x, y, vx, vy) == (1000 * WALL, 120, -600, 800)
    assert after == pytest.approx(1e3 * (HIT_AT + 0.02), abs=1)
    assert shown[-1]["plan"]["contacts"] == []


def test_what_happened_is_told_at_its_time(frames):
    (impact,) = frames[-1]["impacts"] if "impacts" in frames[-1] else newest(frames, "impacts", 9.0)
    assert impact["kind"] == "deliberate"
    assert impact["t"] == pytest.approx(HIT_AT - 0.003 - ZERO, abs=2e-3)
    assert (impact["at"], impact["normal"], impact["speed"]) == ([1000 * WALL, 100], [-1000, 0], 500)
    assert newest(frames, "impacts", HIT_AT - ZERO - 0.02) == []
    assert newest(frames, "impacts", HIT_AT - ZERO + 0.011) == [impact]
    assert newest(frames, "counts", 9.0) == {"deliberate": 1, "foreseen": 0, "other": 0}
    statuses = [frame["goal"]["status"] for frame in frames if "goal" in frame]
    assert statuses == ["none", "accepted", "executing", "succeeded"]
    assert newest(frames, "goal", 9.0)["at"] == [0, 100]
    assert [frame["costs"]["planning_time"] for frame in frames if "costs" in frame] == [3.25]
    assert newest(frames, "hold", 9.0)["state"] == "held"
    assert sum(len(frame.get("periods", [])) for frame in frames) == len(bouncing_run().sent_commands) - 1


def test_of_a_run_that_no_clock_paced_it_tells_no_pace_of_the_machine(tmp_path, frames):
    folder = played_folder(tmp_path)
    parameters = folder / "parameters.yaml"
    parameters.write_text(parameters.read_text().replace("speed_factor: 1.0", "speed_factor: 0.0"))
    unpaced = recording_in(write_run_page(folder).read_text(encoding="utf-8"))["frames"]
    for part in ("machine", "periods"):
        assert [any(part in frame for frame in each) for each in (frames, unpaced)] == [True, False], part


def test_a_page_too_large_keeps_the_first_of_what_is_heavy_and_all_that_happened(frames):
    kept = thinned(frames, 8)
    for part in ("robot", "trail", "impacts", "goal", "costs"):
        assert [part in each for each in kept] == [part in each for each in frames], part
    for part, one_in in (("scan", 8), ("plan", 2)):
        assert [f[part] for f in kept if part in f] == [f[part] for f in frames if part in f][::one_in], part


# ---- it needs nothing but itself


def test_it_loads_nothing_and_its_policy_allows_its_own_script_and_style_alone(page):
    parsed = Parsed(page)
    tags = [tag for tag, _, _ in parsed.elements]
    assert not {"iframe", "object", "embed", "base", "form"} & set(tags)
    for tag, attributes, _ in parsed.elements:
        for name, value in attributes.items():
            assert not name.startswith("on"), (tag, name)
            assert name != "style", tag
            if name in ("src", "href", "srcset", "data", "action", "poster", "xlink:href"):
                assert value.startswith(("data:", "#")), (tag, value)
    ((policy, place),) = (
        (attributes["content"], k)
        for k, (_, attributes, _) in enumerate(parsed.elements)
        if attributes.get("http-equiv") == "Content-Security-Policy"
    )
    rules = dict(rule.split(maxsplit=1) for rule in policy.split("; "))
    assert rules["default-src"] == "'none'"
    assert "unsafe" not in policy
    texts = {"script-src": parsed.text("script", type="module"), "style-src": parsed.text("style")}
    for rule, text in texts.items():
        assert rules[rule] == f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
    # the policy holds for what follows it
    assert place < min(tags.index("script"), tags.index("style"))


def test_a_name_that_is_a_script_stays_text_and_a_strategy_misses_what_it_remembers(tmp_path):
    name = "</title><img src=x onerror=alert(1)><script>alert(1)</script>a\"b'c&d"
    text = write_run_page(played_folder(tmp_path, one_pose(), name, "bounce", ())).read_text()
    parsed = Parsed(text)
    assert not any("onerror" in attributes for _, attributes, _ in parsed.elements)
    assert "<script>alert" not in text
    recording = recording_in(text)
    assert recording["title"].startswith(name)
    assert recording["frames"][0]["about"]["world"] == name
    assert parsed.text("title").startswith(name)
    assert "remembered" in " ".join(recording["notes"])
    (frame,) = recording["frames"]
    assert (frame["t"], frame["goal"]["status"]) == (0.0, "none")


# ---- what it is made from


FAR, NOWHERE = PoseRow(1.0, 1e9, 0.0, 0.0, 0.0, 0.0, 1.0), RunLog()
UNREADABLE = [
    (RECORDING, None, one_pose(), f"{RECORDING}: cannot be read"),
    ("log", "", NOWHERE, f"{RECORDING}: no poses"),
    ("log", "", RunLog(poses=[FAR]), "expected at most 1e.06"),
    ("summary.json", "[]", one_pose(), "summary.json: expected JSON"),
]


def test_what_cannot_be_read_is_said_in_a_sentence(tmp_path):
    with pytest.raises(RunError, match="not a folder"):
        write_run_page(tmp_path / "gone")
    for number, (file, text, log, words) in enumerate(UNREADABLE):
        folder = played_folder(tmp_path / str(number), log, said=())
        if text is None:
            (folder / file).unlink()
        else:
            (folder / file).write_text(text)
        with pytest.raises(RunError, match=words) as error:
            write_run_page(folder)
        assert "\n" not in str(error.value)
        assert str(folder) in str(error.value)
        assert not (folder / "run.html").exists()


def test_replay_writes_the_same_page_each_time_or_says_in_a_sentence_why_not(tmp_path, capsys):
    folder = played_folder(tmp_path, one_pose(), said=())
    texts = []
    for named in (folder, folder / RECORDING):
        assert main(["--page", str(named)]) == 0
        assert str(folder / "run.html") in capsys.readouterr().out
        texts.append((folder / "run.html").read_text(encoding="utf-8"))
    assert texts[0] == texts[1]
    assert not [path for path in folder.iterdir() if path.name.startswith(".")]
    (folder / RECORDING).unlink()
    assert main(["--page", str(folder)]) == 2
    assert capsys.readouterr().err.startswith(f"replay: {folder / RECORDING}")
