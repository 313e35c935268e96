"""The picture of world and path."""

from dataclasses import replace

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_core.worlds import World
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.bringup.results import draw_pictures, write_results
from collplan_ros.bringup.robots import ROBOTS
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.pictures.drawing import SPEED_COLORS, speed_color
from collplan_ros.pictures.title import wrapped
from collplan_ros.pictures.trajectory_png import draw_trajectory
from collplan_ros.runs.impact_log import impacts_of
from made_runs import WINDOW, bouncing_run, room


@pytest.fixture
def drawn(monkeypatch):
    """The figures that are drawn, instead of their files."""
    from matplotlib.figure import Figure

    figures = []

    def save(figure, path, **_):
        path.touch()
        figures.append(figure)

    monkeypatch.setattr(Figure, "savefig", save)
    return figures


def test_a_world_whose_path_looks_like_a_formula_is_drawn_as_it_is_written(tmp_path):
    log = bouncing_run()
    impacts, title = impacts_of(log, room(), WINDOW), "/tmp/a $\\x{ and $ b/my_arena.yaml, harness"
    draw_trajectory(tmp_path / "a.png", log, impacts, room(), np.zeros(2), Settings(), title)
    assert (tmp_path / "a.png").stat().st_size > 1000


@pytest.mark.parametrize("name", ["room", "a" * 300, "my arena " * 30, "two\nlines"])
def test_the_title_lies_within_the_picture_and_names_the_world_by_its_name(tmp_path, drawn, name):
    settings = Settings().with_values({"simulator.world": "/home/user/collplan/my_arena.yaml"})
    prepared = Preparation(ROBOTS["sim"], "local", settings, replace(room(), name=name), np.zeros(2), {})
    folder = RunFolder(tmp_path)
    results = write_results(folder, bouncing_run(), prepared, "reached", Options())
    assert draw_pictures(folder, results, prepared) == ""
    (figure,) = drawn
    figure.draw_without_rendering()
    extents = [text.get_window_extent() for text in (figure._suptitle, figure.axes[0].title) if text.get_text()]
    assert extents
    for extent in extents:
        assert extent.x0 >= 0.0
        assert extent.x1 <= figure.bbox.width
    title = figure._suptitle.get_text()
    assert title.startswith(name[:3])
    assert "/home/user" not in title
    assert "goal reached in 1.8 s, 0.67 m, 1 impact" in title


def test_speeds_have_the_colours_of_the_animation(tmp_path, drawn):
    log, settings = bouncing_run(), Settings()
    draw_trajectory(tmp_path / "a.png", log, impacts_of(log, room(), WINDOW), room(), np.zeros(2), settings, "title")
    (trail,) = drawn[0].axes[0].collections
    middles = (np.arange(SPEED_COLORS) / (SPEED_COLORS - 1)) * settings.robot.max_speed
    expected = np.array([speed_color(k) for k in range(SPEED_COLORS)]) / 255.0
    np.testing.assert_allclose(trail.to_rgba(middles)[:, :3], expected, atol=0.02)


def test_a_title_is_broken_between_words_and_within_those_that_are_too_long():
    assert wrapped("one two three\nfour", lambda text: len(text) <= 7) == "one two\nthree\nfour"
    assert wrapped("abcdefghij k", lambda text: len(text) <= 4) == "abcd\nefgh\nij k"


@pytest.mark.parametrize("height", [0.5, 3.0, 12.0], ids=["wide", "room", "tall"])
def test_legend_and_axis_label_lie_apart(tmp_path, drawn, height):
    world = World("arena", (), np.zeros((0, 3)), (-2.0, -0.5 * height, 2.5, 0.5 * height), True, None, None)
    log = bouncing_run()
    draw_trajectory(tmp_path / "a.png", log, impacts_of(log, room(), WINDOW), world, np.zeros(2), Settings(), "title")
    (figure,) = drawn
    figure.draw_without_rendering()
    (legend,) = figure.legends
    label = figure.axes[0].xaxis.label.get_window_extent()
    assert len(legend.get_texts()) == 4
    assert not legend.get_window_extent().overlaps(label)
    assert legend.get_window_extent().y0 >= 0.0
