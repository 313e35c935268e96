"""Runs beside each other, from run folders made by hand."""

import csv
import json

import numpy as np
import pytest
from PIL import Image

from collplan_core.parameters import Settings
from collplan_core.parameters.file import write_parameters
from collplan_ros.pictures.compare_runs import main
from collplan_ros.pictures.drawing import SMOOTHING, Trail, canvas_of, speed_color, trail_of
from collplan_ros.pictures.palette import DELIBERATE, OTHER
from collplan_ros.pictures.shown_run import read_shown_run
from collplan_ros.pictures.side_by_side import FRAME_PERIOD, GAP, HEAD, LAST_FRAME, LONG_SIDE, _view
from collplan_ros.runs.impact_log import COLUMNS as IMPACT_COLUMNS
from collplan_ros.runs.run_error import RunError
from collplan_ros.runs.trajectory_file import COLUMNS as TRAJECTORY_COLUMNS

WRITTEN, REFUSED = 0, 2
START, GOAL = np.array([0.6, 0.4]), np.array([1.8, 0.4])
ABOVE = np.array([0.0, 0.04])
"""Within the robot, off the mark in the middle of the goal."""
HIT_AT, HIT = 0.2, np.array([[0.9, 0.7], [1.5, 0.7]])


def run_folder(parent, name, duration, strategy="bounce", world="corridor"):
    """A run from START to GOAL that takes `duration`, with a hit of either kind at HIT_AT."""
    folder = parent / name
    folder.mkdir(parents=True)
    chosen = {"planner.strategy": strategy, "lidar.world": world, "simulator.world": world}
    write_parameters(Settings().with_values(chosen), folder / "parameters.yaml")
    (folder / "summary.json").write_text(json.dumps({"simulated": True, "goal": GOAL.tolist(), "outcome": "reached"}))
    with (folder / "trajectory.csv").open("w", newline="") as file:
        rows = csv.DictWriter(file, TRAJECTORY_COLUMNS, restval="0.0")
        rows.writeheader()
        for t in np.arange(-0.1, duration + 1e-9, 0.01):
            x, y = START + min(max(t / duration, 0.0), 1.0) * (GOAL - START)
            rows.writerow({"t": f"{t:.6f}", "x": x, "y": y, "maneuver": "free_space"})
    with (folder / "impacts.csv").open("w", newline="") as file:
        rows = csv.DictWriter(file, IMPACT_COLUMNS, restval="0.0")
        rows.writeheader()
        for (x, y), kind in zip(HIT, ("true", "false"), strict=True):
            rows.writerow({"t": HIT_AT, "x": x, "y": y, "foreseen": "true", "deliberate": kind})
    return folder


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    parent = tmp_path_factory.mktemp("runs")
    return run_folder(parent, "slow", 0.6, strategy="avoid"), run_folder(parent, "fast", 0.4)


@pytest.fixture(scope="module")
def frames(folders, tmp_path_factory):
    """Each frame's picture and how long it stays [ms]."""
    out = tmp_path_factory.mktemp("pictures") / "both.gif"
    assert main([*map(str, folders), "--out", str(out)]) == WRITTEN
    with Image.open(out) as image:
        found = []
        for k in range(image.n_frames):
            image.seek(k)
            found.append((image.convert("RGB"), image.info["duration"]))
    return found


@pytest.fixture(scope="module")
def canvas(folders):
    return canvas_of(_view([read_shown_run(folder) for folder in folders]), LONG_SIDE)


def color_at(frame, canvas, panel, point):
    """The color of a point of the world [m] in a run's panel."""
    ((x, y),) = canvas.at(point)
    left = panel * (round(canvas.size[0] / SMOOTHING) + GAP)
    return frame.getpixel((left + int(x / SMOOTHING), HEAD + int(y / SMOOTHING)))


def near(color, other):
    expected = tuple(int(other[i : i + 2], 16) for i in (1, 3, 5)) if isinstance(other, str) else other
    return max(abs(a - b) for a, b in zip(color, expected, strict=True)) < 40


def test_both_runs_share_one_clock(frames, canvas):
    """Each robot is where it was at the frame's time, and stays at the goal once it is there."""
    assert len(frames) == int(0.6 / FRAME_PERIOD) + 2
    for k, (picture, _) in enumerate(frames):
        for panel, duration in enumerate((0.6, 0.4)):
            share = min(k * FRAME_PERIOD / duration, 1.0)
            robot = START + share * (GOAL - START)
            assert near(color_at(picture, canvas, panel, robot + ABOVE), (255, 255, 255))


def test_frames_stay_for_their_period_and_the_last_one_longer(frames):
    *durations, last = (duration for _, duration in frames)
    assert set(durations) == {1e3 * FRAME_PERIOD}
    assert last == pytest.approx(1e3 * LAST_FRAME, abs=2e3 * FRAME_PERIOD)


def test_contacts_are_marked_by_kind_from_their_time_on(frames, canvas):
    before, after = frames[2][0], frames[-1][0]
    for panel in (0, 1):
        for point, color in zip(HIT, (DELIBERATE, OTHER), strict=True):
            assert near(color_at(after, canvas, panel, point), color)
            assert color_at(before, canvas, panel, point) != color_at(after, canvas, panel, point)


def test_half_the_speed_takes_twice_the_frames(folders, tmp_path):
    out = tmp_path / "slow.gif"
    assert main([*map(str, folders), "--out", str(out), "--speed", "0.5"]) == WRITTEN
    with Image.open(out) as image:
        assert image.n_frames == int(0.6 / (0.5 * FRAME_PERIOD)) + 2


def test_colors_of_the_trail_are_by_speed():
    times = np.linspace(0.0, 2.0, 201)
    x = np.where(times < 1.0, 0.15 * times, 0.15 + 1.15 * (times - 1.0))
    trail = trail_of(times, np.column_stack([x, np.zeros(201)]), 1.2)
    assert set(trail.color[:95]) == {1}
    assert set(trail.color[105:]) == {11}
    assert len({speed_color(k) for k in range(12)}) == 12


def test_between_two_poses_a_robot_is_on_the_way():
    trail = Trail(np.array([0.0, 1.0]), np.array([[0.0, 0.0], [2.0, 4.0]]), np.zeros(2, int))
    assert trail.at(0.25) == pytest.approx([0.5, 1.0])
    assert trail.at(7.0) == pytest.approx([2.0, 4.0])


def refused(capsys, *arguments):
    assert main([*map(str, arguments)]) == REFUSED
    return capsys.readouterr().err


def test_one_run_or_two_worlds_are_refused(folders, tmp_path, capsys):
    out = tmp_path / "no.gif"
    assert "at least two" in refused(capsys, folders[0], "--out", out)
    other = run_folder(tmp_path, "other", 0.2, world="slalom")
    assert "corridor, slalom, expected one world" in refused(capsys, folders[0], other, "--out", out)
    assert not out.exists()


def test_a_file_that_cannot_be_written_is_named(folders, tmp_path, capsys):
    out = tmp_path / "missing" / "a.gif"
    assert f"--out {out}: cannot be written" in refused(capsys, *folders, "--out", out)


@pytest.mark.parametrize("arguments", [["--speed", "0"], ["--speed", "nan"], ["--out", "a.mp4"]])
def test_options_that_do_not_fit_are_named(folders, capsys, arguments):
    with pytest.raises(SystemExit):
        main([*map(str, folders), *arguments])
    assert f"argument {arguments[0]}: got {arguments[1]}, expected" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("file", "found", "put", "said"),
    [
        ("impacts.csv", "deliberate", "on_purpose", "no column deliberate"),
        ("impacts.csv", ",true\r\n", ",perhaps\r\n", "line 2, deliberate: got 'perhaps', expected true or false"),
        ("impacts.csv", "0.9", "nine", "line 2, x: got 'nine', expected a number"),
        ("summary.json", '"goal"', '"gaol"', "expected JSON with outcome, and goal"),
        ("trajectory.csv", None, ",".join(TRAJECTORY_COLUMNS) + "\n", "no poses"),
    ],
)
def test_what_bringup_did_not_write_is_named(tmp_path, file, found, put, said):
    folder = run_folder(tmp_path, "run", 0.2)
    text = (folder / file).read_bytes().decode()
    (folder / file).write_bytes((text.replace(found, put) if found else put).encode())
    with pytest.raises(RunError, match=said) as error:
        read_shown_run(folder)
    assert file in str(error.value)
