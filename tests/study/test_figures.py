"""What figures of studies show can be seen."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from collplan_core.evaluation.run_end import REACHED
from collplan_core.worlds import load_world
from collplan_study.analysis.bounce_results import GroupResults
from collplan_study.analysis.cells import Cell
from collplan_study.analysis.gains import Gain, WorldGain
from collplan_study.analysis.groups import Group
from collplan_study.analysis.paths import RunPath
from collplan_study.analysis.statistics import Estimate
from collplan_study.report.bounce_figures import draw_worlds
from collplan_study.report.figures import COLOURS, GROUND, OTHER_COLOURS, SOLID, PathPanel, draw_paths

STRATEGIES = ("bounce", "tolerate", "avoid", "stop_guarantee")
LEAST_CONTRAST = 2.5
"""Of thin lines; text would need 4.5."""


def luminance(color):
    channels = np.array(to_rgb(color))
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(one, other):
    """Contrast of two colours as WCAG defines it, from 1 to 21."""
    darker, lighter = sorted((luminance(one), luminance(other)))
    return (lighter + 0.05) / (darker + 0.05)


def over(color, alpha, ground):
    return alpha * np.array(to_rgb(color)) + (1.0 - alpha) * np.array(to_rgb(ground))


def panels(strategies):
    points = np.array([[0.4, 0.4], [1.0, 0.6], [1.4, 0.4]])
    run = RunPath(points, REACHED, np.array([[1.0, 0.6]]))
    return [PathPanel(load_world("corridor"), 0.09, 0.1, name, 0.05, [run]) for name in strategies]


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_paths_and_impacts_stand_out_from_ground_and_obstacles(strategy):
    axes = draw_paths([panels(STRATEGIES)]).axes[STRATEGIES.index(strategy)]
    path, impacts = (line for line in axes.lines if len(line.get_xdata()) in (1, 3) and line.get_color() != "#000000")
    assert contrast(over(path.get_color(), path.get_alpha() or 1.0, GROUND), GROUND) >= LEAST_CONTRAST
    assert contrast(impacts.get_markerfacecolor(), SOLID) >= LEAST_CONTRAST
    assert contrast(impacts.get_markeredgecolor(), GROUND) >= LEAST_CONTRAST


def test_no_two_strategies_look_alike():
    colours = [*COLOURS.values(), *OTHER_COLOURS]
    assert len(set(colours)) == len(colours)
    distances = [np.abs(np.subtract(to_rgb(a), to_rgb(b))).max() for a in colours for b in colours if a != b]
    assert min(distances) > 0.15


def group(name, saved):
    estimate = Estimate(float(np.mean(saved)), min(saved), max(saved))
    gain = Gain("bounce", "avoid", len(saved), len(saved), estimate, estimate, estimate)
    worlds = [WorldGain(f"{name}:{k}", 1, value, 1.0, 1.0) for k, value in enumerate(saved)]
    cells: list[Cell] = []
    return GroupResults(Group(name, (name,), True), cells, [], [gain], worlds)


@pytest.mark.parametrize("n_groups", [1, 5])
def test_the_figure_of_worlds_says_what_is_what_and_is_as_wide_as_it_needs(n_groups):
    figure = draw_worlds([group(f"family {k}", [1.0, 5.0]) for k in range(n_groups)], "bounce", "avoid")
    figure.draw_without_rendering()
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["a world", "mean, 95 % interval"]
    assert not legend.get_window_extent().overlaps(figure.axes[0].get_window_extent())
    low, high = figure.axes[0].get_xlim()
    assert figure.get_figwidth() / (high - low) > 1.0
    assert figure.get_figwidth() <= 5.0 or n_groups > 1
    caption = figure._supxlabel.get_window_extent()
    assert caption.x0 >= 0.0
    assert caption.x1 <= figure.bbox.width
