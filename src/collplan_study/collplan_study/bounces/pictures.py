"""The pictures of a study of bounces: time saved world by world and in each variant, and overlaid paths."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from collplan_study.analysis.statistics import Estimate
from collplan_study.bounces.results import MAIN, BounceResults, GroupResults, VariantResults
from collplan_study.report.content import Picture
from collplan_study.report.figures import STYLE, add_caption, new_figure, saved_picture
from collplan_study.report.maps import draw_paths
from collplan_study.report.study_data import StudyData
from collplan_study.tables.rows import axes_of

LEAST_DRAWN = 2
"""Worlds of each headline group whose paths are drawn because least is saved there; the one where most is follows."""
OURS_COLOUR, WORLD_COLOUR, ZERO = "#0072b2", "#6b7785", "#b03a00"
WIDEST = 40.0
"""Larger savings and losses are drawn at this value [%]: a run that never arrives would dwarf all others."""
NARROWEST, OF_A_GROUP, FULL_WIDTH = 4.4, 1.1, 7.6
"""Least width of the figure of worlds, what each group adds to it, and the width of the page [inch]."""
CAPTION = "{1} ({0}.png, .svg)"


def bounce_pictures(data: StudyData, results: BounceResults) -> Iterator[Picture]:
    """Draws the pictures of a study and saves them."""
    both = (results.ours, results.against)
    against = " against ".join(both)
    if any(each.worlds for each in results.groups):
        drawn, words = draw_worlds(results.groups, *both), f"Time saved world by world, {against}"
        yield saved_picture(data.folder, "by-world", drawn, words, CAPTION)
    headlines = [each for each in results.variants if each.group.headline]
    if headlines:
        drawn, words = draw_variants(headlines, *both), f"Time saved under each change, {against}"
        yield saved_picture(data.folder, "changes", drawn, words, CAPTION)
    for each in (each for each in results.headlines if each.worlds):
        worlds = [gain.world for gain in each.worlds]
        extremes = dict.fromkeys([*worlds[:LEAST_DRAWN], worlds[-1]])
        drawn = _paths(data, extremes, both)
        words = f"{each.group.name}: where least is saved, and last where most is; circles: deliberate impacts"
        yield saved_picture(data.folder, f"paths-{each.group.name}", drawn, words, CAPTION)


def _paths(data: StudyData, worlds: Iterable[str], both: tuple[str, str]) -> Figure:
    sources = {source.world.name: source for source in data.sources}
    main = data.runs.filter(ablation="")
    labels = main.select("ablation", *axes_of(main.columns)).row(0, named=True)
    firsts = (main.filter(strategy=name).row(0, named=True) for name in both)
    cells = [{key: row[key] for key in ("strategy", "map_period_s")} for row in firsts]
    return draw_paths(data, [sources[world] for world in worlds], labels, cells, deliberate=True)


@rc_context(STYLE)
def draw_worlds(groups: Sequence[GroupResults], ours: str, against: str) -> Figure:
    """Time saved in each world, beside the mean over the worlds with its interval."""
    width = min(max(NARROWEST, 1.0 + OF_A_GROUP * len(groups)), FULL_WIDTH)
    figure = new_figure(width, 3.6)
    axes = figure.add_subplot(ylabel=f"time saved against {against} [%]")
    for place, each in enumerate(groups):
        saved = np.clip([world.saved for world in each.worlds], -WIDEST, WIDEST)
        spread = np.linspace(-0.22, 0.12, len(saved))
        axes.plot(place + spread, saved, "o", markersize=3.5, color=WORLD_COLOUR, label="a world")
        (gain,) = (gain for gain in each.gains if gain.other == against)
        _draw_estimate(axes, place + 0.3, gain.saved, label="mean, 95 % interval")
    axes.axhline(0.0, color=ZERO, linewidth=0.9)
    # as wide for one group as for several
    axes.set_xlim(-0.7, len(groups) - 0.3)
    axes.set_xticks(range(len(groups)), [each.group.name.replace(" ", "\n") for each in groups])
    handles, names = axes.get_legend_handles_labels()
    shown = dict(zip(names, handles, strict=True))
    figure.legend(list(shown.values()), list(shown), loc="outside upper right", ncols=len(shown))
    add_caption(figure, f"{ours}; a world beyond {WIDEST:g} % is drawn at the edge")
    return figure


@rc_context(STYLE)
def draw_variants(variants: Sequence[VariantResults], ours: str, against: str) -> Figure:
    """Mean saving with its interval in each variant, a panel for each group."""
    names = list(dict.fromkeys(each.group.name for each in variants))
    changes = list(dict.fromkeys(each.ablation for each in variants))
    figure = new_figure(7.6, 0.9 + 0.26 * len(changes))
    first: Axes | None = None
    for column, name in enumerate(names):
        axes = figure.add_subplot(1, len(names), column + 1, sharex=first, sharey=first, title=name)
        first = first or axes
        for each in variants:
            if each.group.name == name:
                _draw_estimate(axes, changes.index(each.ablation), each.gain.saved, across=True)
        axes.axvline(0.0, color=ZERO, linewidth=0.9)
        axes.tick_params(labelleft=column == 0)
    assert first is not None
    first.set_yticks(range(len(changes)), [change or MAIN for change in changes])
    first.invert_yaxis()
    add_caption(figure, f"time that {ours} saves against {against} [%]; bars: 95 % intervals of the mean")
    return figure


def _draw_estimate(axes: Axes, place: float, estimate: Estimate, across: bool = False, label: str = "") -> None:
    # None becomes NaN, which is not drawn
    value, low, high = np.array([estimate.value, estimate.low, estimate.high], dtype=float)
    bar = [[value - low], [high - value]]
    look: dict[str, Any] = {"fmt": "s", "markersize": 4.5, "color": OURS_COLOUR, "capsize": 2.5, "linewidth": 1.3}
    if across:
        axes.errorbar(value, place, xerr=bar, label=label, **look)
    else:
        axes.errorbar(place, value, yerr=bar, label=label, **look)
