"""The picture of world and path."""

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_core.worlds import World
from collplan_ros.pictures.trajectory_png import draw_trajectory
from collplan_ros.runs.impact_log import impacts_of
from made_runs import WINDOW, bouncing_run, room


def test_a_world_whose_path_looks_like_a_formula_is_drawn_as_it_is_written(tmp_path):
    log = bouncing_run()
    impacts, title = impacts_of(log, room(), WINDOW), "/tmp/a $\\x{ and $ b/my_arena.yaml, harness"
    draw_trajectory(tmp_path / "a.png", log, impacts, room(), np.zeros(2), Settings(), title)
    assert (tmp_path / "a.png").stat().st_size > 1000


@pytest.mark.parametrize("height", [0.5, 3.0, 12.0], ids=["wide", "room", "tall"])
def test_legend_and_axis_label_lie_apart(tmp_path, monkeypatch, height):
    from matplotlib.figure import Figure

    drawn = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, *_, **__: drawn.append(figure))
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
