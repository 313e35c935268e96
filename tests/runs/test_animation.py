"""The animation of a run."""

import numpy as np
import pytest
from PIL import Image

from collplan_core.parameters import Settings
from collplan_core.worlds import World
from collplan_ros.pictures import animation
from collplan_ros.pictures.animation import LONG_SIDE, NARROWEST, draw_animation
from collplan_ros.pictures.drawing import SPEED_COLORS, speed_color
from collplan_ros.pictures.gif_file import save_gif
from collplan_ros.pictures.legend import MARGIN, Entry, legend, run_entries
from collplan_ros.pictures.palette import DELIBERATE, FREE, GOAL, OBSTACLE, PLAN, SCAN
from collplan_ros.pictures.title import shortened
from collplan_ros.runs.impact_log import impacts_of
from collplan_ros.runs.run_log import PlanRow
from made_runs import SPEED, WINDOW, bouncing_run, room

TITLE = "room, harness, seed 0 (simulated)"


def run_with_a_plan_hidden_at_its_end():
    """The plan of the last frame lies under the robot."""
    log = bouncing_run()
    last = log.poses[-1]
    at = np.array([last.x, last.y])
    log.plans = [plan for plan in log.plans if plan.stamp < last.stamp - 0.3]
    log.plans.append(PlanRow(last.stamp - 0.2, last.stamp + np.array([0.0, 0.1]), np.stack([at, at])))
    return log


def frames_of(tmp_path, log, world=None, title=TITLE):
    world, path = world or room(), tmp_path / "run.gif"
    draw_animation(path, log, impacts_of(log, world, WINDOW), world, np.zeros(2), Settings(), title)
    with Image.open(path) as image:
        found = []
        for k in range(image.n_frames):
            image.seek(k)
            found.append(np.asarray(image.convert("RGB")).astype(int))
    return found


def count_of(frame, color, height):
    """Number of pixels above `height` that have a colour, but for the rounding of a palette."""
    wanted = [int(color[i : i + 2], 16) for i in (1, 3, 5)] if isinstance(color, str) else color
    return int((np.abs(frame[:height] - wanted).max(axis=2) <= 6).sum())


def test_what_is_drawn_has_its_own_colours_in_every_frame_though_the_last_one_hides_it(tmp_path):
    frames = frames_of(tmp_path, run_with_a_plan_hidden_at_its_end())
    height = frames[0].shape[0] - 60
    assert count_of(frames[-1], PLAN, height) < 5
    for color in (PLAN, FREE, GOAL, OBSTACLE, SCAN):
        assert min(count_of(frame, color, height) for frame in frames[:6]) > 5, color
    assert count_of(frames[-1], DELIBERATE, height) > 5
    slow_and_fast = [int(SPEED / Settings().robot.max_speed * SPEED_COLORS - 0.5 + k) for k in (0, 1)]
    assert sum(count_of(frames[8], speed_color(k), height) for k in slow_and_fast) > 5


def test_the_text_below_the_world_is_as_wide_as_it_and_changes_with_the_run(tmp_path):
    frames = frames_of(tmp_path, bouncing_run())
    height = animation.CLOCK + animation.TITLE + legend(LONG_SIDE, run_entries(1.2)).height
    below = [frame[2 - height :] for frame in frames]
    assert any((each != below[0]).any() for each in below[1:])
    ink = [np.flatnonzero(np.ptp(each, axis=0).max(axis=1) > 60) for each in below]
    assert min(each.min() for each in ink) >= MARGIN - 4
    assert max(each.max() for each in ink) < frames[0].shape[1] - 1


@pytest.mark.parametrize("height", [0.6, 3.0, 30.0], ids=["wide", "room", "tall"])
def test_every_arena_has_room_for_the_text(tmp_path, height):
    world = World("arena", (), np.zeros((0, 3)), (-2.0, -0.5 * height, 2.5, 0.5 * height), True, None, None)
    frames = frames_of(tmp_path, bouncing_run(), world, title="a very long name, " * 20)
    assert frames[0].shape[1] >= NARROWEST * LONG_SIDE
    assert max(frames[0].shape[:2]) <= LONG_SIDE + 140


def test_a_name_with_line_breaks_is_drawn(tmp_path):
    assert frames_of(tmp_path, bouncing_run(), title="a b\tc")


def test_a_legend_takes_the_lines_it_needs_and_leaves_nothing_out():
    entries = run_entries(1.2)
    one, three = legend(2000, entries), legend(250, entries)
    assert three.height >= 3 * one.height
    drawn = []
    spied = [Entry(each.words, lambda draw, x, y: drawn.append((x, y))) for each in entries]
    legend(250, spied)
    assert len(set(drawn)) == len(entries)


@pytest.mark.parametrize("length", [3, 4, 10, 25, 26, 30])
def test_a_text_that_does_not_fit_loses_its_middle(length):
    text = "abcdefghijklmnopqrstuvwxyz"
    shown = shortened(text, lambda each: len(each) <= length)
    assert len(shown) == min(length, 26)
    assert shown == text or (shown[0] in "a." and shown[-1] in "z.")


def test_a_colour_that_only_some_frames_show_is_kept(tmp_path):
    """Another palette than that of the last frame alone."""
    plain = Image.new("RGB", (60, 40), FREE)
    plain.paste(DELIBERATE, (0, 0, 9, 9))
    shown = plain.copy()
    shown.paste(PLAN, (20, 10, 40, 30))
    shown.paste("#123456", (45, 10, 55, 30))
    path = tmp_path / "a.gif"
    save_gif(path, [plain, *[shown] * 8, plain], 0.1, 0.5)
    with Image.open(path) as image:
        image.seek(1)
        frame = np.asarray(image.convert("RGB")).astype(int)
    assert count_of(frame, PLAN, 40) == 20 * 20
    assert count_of(frame, "#123456", 40) == 10 * 20
