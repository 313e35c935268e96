"""Pictures of a run hold it: the animation, two runs beside each other; what cannot be drawn is named."""

import re
from importlib.resources import files
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from collplan_core.parameters import Settings
from collplan_ros.pictures import palette
from collplan_ros.pictures.animation import draw_animation
from collplan_ros.pictures.compare_runs import main
from collplan_ros.pictures.drawing import Trail, trail_of
from collplan_ros.pictures.palette import DELIBERATE, FREE, GOAL, OBSTACLE, OTHER, PLAN, SCAN, speed_colors
from collplan_ros.pictures.shown_run import read_shown_run
from collplan_ros.pictures.side_by_side import FRAME_PERIOD, GAP, HEAD, LAST_FRAME
from collplan_ros.pictures.title import shortened, wrapped
from collplan_ros.runs.impact_log import impacts_of
from collplan_ros.runs.run_error import RunError
from collplan_ros.runs.run_log import PlanRow
from collplan_ros.runs.trajectory_file import COLUMNS as TRAJECTORY_COLUMNS
from made_runs import WINDOW, bouncing_run, room
from played_folders import HITS, drawn_folder

WRITTEN, REFUSED = 0, 2
FEET = 60
"""Height of the text below a picture, at least [pixel]."""


def frames_of(path):
    """Each frame of a GIF as an array, and how long it stays [ms]."""
    with Image.open(path) as image:
        found = []
        for k in range(image.n_frames):
            image.seek(k)
            found.append((np.asarray(image.convert("RGB")).astype(int), image.info["duration"]))
    return found


def count_of(frame, color):
    """Number of pixels above the text that have a colour, but for the rounding of a palette."""
    wanted = [int(color[i : i + 2], 16) for i in (1, 3, 5)]
    return int((np.abs(frame[:-FEET] - wanted).max(axis=2) <= 6).sum())


def test_an_animation_shows_everything_though_its_last_frame_hides_the_plan(tmp_path):
    """Else its colour would be missing from the palette of all frames."""
    log, world, path = bouncing_run(), room(), tmp_path / "run.gif"
    last = log.poses[-1]
    under = np.array([[last.x, last.y]] * 2)
    log.plans = [plan for plan in log.plans if plan.stamp < last.stamp - 0.3]
    log.plans.append(PlanRow(last.stamp - 0.2, last.stamp + np.array([0.0, 0.1]), under))
    draw_animation(path, log, impacts_of(log, world, WINDOW), world, np.zeros(2), Settings(), "room, harness, seed 0")
    frames = [frame for frame, _ in frames_of(path)]
    assert count_of(frames[-1], PLAN) < 5
    for color in (PLAN, FREE, GOAL, OBSTACLE, SCAN):
        assert min(count_of(frame, color) for frame in frames[:6]) > 5, color
    assert count_of(frames[0], DELIBERATE) == 0
    assert count_of(frames[-1], DELIBERATE) > 5


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    parent = tmp_path_factory.mktemp("runs")
    return drawn_folder(parent, "slow", 0.6, strategy="avoid"), drawn_folder(parent, "fast", 0.4)


def test_runs_beside_each_other_share_one_clock_and_each_stays_where_it_ended(folders, tmp_path):
    out = tmp_path / "both.gif"
    assert main([*map(str, folders), "--out", str(out)]) == WRITTEN
    frames = frames_of(out)
    assert len(frames) == int(0.6 / FRAME_PERIOD) + 2
    *durations, last = (duration for _, duration in frames)
    assert set(durations) == {1e3 * FRAME_PERIOD}
    assert last == pytest.approx(1e3 * LAST_FRAME, abs=2e3 * FRAME_PERIOD)
    width = (frames[0][0].shape[1] - GAP) // 2
    panels = [(frame[HEAD:-FEET, :width], frame[HEAD:-FEET, -width:]) for frame, _ in frames]
    for panel, duration in enumerate((0.6, 0.4)):
        shown = [each[panel] for each in panels]
        changes = [int((np.abs(b - a).max(axis=2) > 40).sum()) for a, b in pairwise(shown)]
        ended = round((duration + 0.3) / FRAME_PERIOD)  # a mark is drawn larger at first
        assert min(changes[: round(duration / FRAME_PERIOD)]) > 20
        assert max(changes[ended:], default=0) == 0
        for color in (DELIBERATE, OTHER):
            counts = [count_of(each, color) for each in shown]
            assert max(counts[: round(HITS[0] / FRAME_PERIOD)]) < 5
            assert counts[-1] > 5
    slow = tmp_path / "slow.gif"
    assert main([*map(str, folders), "--out", str(slow), "--speed", "0.5"]) == WRITTEN
    with Image.open(slow) as image:
        assert image.n_frames == int(0.6 / (0.5 * FRAME_PERIOD)) + 2


def test_a_trail_is_coloured_by_speed_and_a_robot_is_on_it():
    times = np.linspace(0.0, 2.0, 201)
    x = np.where(times < 1.0, 0.15 * times, 0.15 + 1.15 * (times - 1.0))
    trail = trail_of(times, np.column_stack([x, np.zeros(201)]), 1.2)
    assert set(trail.color[:95]) == {1}
    assert set(trail.color[105:]) == {11}
    trail = Trail(np.array([0.0, 1.0]), np.array([[0.0, 0.0], [2.0, 4.0]]), np.zeros(2, int))
    assert trail.at(0.25) == pytest.approx([0.5, 1.0])
    assert trail.at(7.0) == pytest.approx([2.0, 4.0])


def test_pictures_have_the_colours_of_the_page():
    page = (files("collplan_ros.view") / "page" / "colors.js").read_text(encoding="utf-8")
    light = dict(re.findall(r'(\w+): "(#\w{6})"', page[page.index("const LIGHT") : page.index("const DARK")]))
    names = {"TEXT": "text", "OBSTACLE": "solid", "WALL": "edge", "PLAN": "plotLine"}
    names |= {name: name.lower() for name in ("ROBOT", "GOAL", "SCAN", "DELIBERATE", "FORESEEN", "OTHER", "OUTLINE")}
    assert {name: getattr(palette, name) for name in names} == {name: light[each] for name, each in names.items()}
    (stops,) = re.findall(r"const SPEED = \[([^]]+)\]", page)
    assert re.findall(r"#\w{6}", stops) == list(palette.SLOW_TO_FAST)


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0))
@settings(derandomize=True, deadline=None, max_examples=30)
def test_faster_is_lighter(one, other):
    """By the lightness that the eye sees, so that colours are not needed."""
    slow, fast = speed_colors(np.sort([one, other])) @ [0.2126, 0.7152, 0.0722]
    assert slow <= fast + 1e-9


def test_titles_are_broken_between_words_or_lose_their_middle():
    assert wrapped("one two three\nfour", lambda text: len(text) <= 7) == "one two\nthree\nfour"
    assert wrapped("abcdefghij k", lambda text: len(text) <= 4) == "abcd\nefgh\nij k"
    letters = "abcdefghijklmnopqrstuvwxyz"
    for length in (3, 4, 10, 25, 26, 30):
        shown = shortened(letters, lambda each: len(each) <= length)  # noqa: B023
        assert len(shown) == min(length, 26)
        assert shown == letters or (shown[0] in "a." and shown[-1] in "z.")


def test_what_cannot_be_compared_is_named(folders, tmp_path, capsys):
    out, missing = tmp_path / "no.gif", tmp_path / "missing" / "a.gif"
    other = drawn_folder(tmp_path, "other", 0.2, world="slalom")
    for arguments, said in (
        ((folders[0], "--out", out), "at least two"),
        ((folders[0], other, "--out", out), "corridor, slalom"),
        ((*folders, "--out", missing), f"--out {missing}"),
    ):
        assert main([*map(str, arguments)]) == REFUSED
        assert said in capsys.readouterr().err
    assert not out.exists()
    for option, value in (("--speed", "0"), ("--speed", "nan"), ("--out", "a.mp4")):
        with pytest.raises(SystemExit):
            main([*map(str, folders), option, value])
        assert f"argument {option}: got {value}, expected" in capsys.readouterr().err


def test_what_bringup_did_not_write_is_named(tmp_path):
    for number, (file, found, put, said) in enumerate(
        (
            ("impacts.csv", "deliberate", "on_purpose", "no column deliberate"),
            ("impacts.csv", ",true\r\n", ",perhaps\r\n", "line 2, deliberate: got 'perhaps'"),
            ("impacts.csv", "0.9", "nine", "line 2, x: got 'nine'"),
            ("summary.json", '"goal"', '"gaol"', "expected JSON"),
            ("trajectory.csv", None, ",".join(TRAJECTORY_COLUMNS) + "\n", "no poses"),
        )
    ):
        folder = drawn_folder(tmp_path, f"run_{number}", 0.2)
        text = (folder / file).read_bytes().decode()
        (folder / file).write_bytes((text.replace(found, put) if found else put).encode())
        with pytest.raises(RunError, match=said) as error:
            read_shown_run(folder)
        assert file in str(error.value)
