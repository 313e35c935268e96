"""The figures of a study of bounces, drawn and put into the study's folder."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from collplan_core.evaluation.impact_matching import DELIBERATE_SPEED
from collplan_study.analysis.bounce_results import BounceResults, GroupResults
from collplan_study.analysis.runs import Runs, cases_of
from collplan_study.question.sources import Source
from collplan_study.report.bounce_figures import draw_variants, draw_worlds
from collplan_study.report.figures import PathPanel, draw_paths, save_figure
from collplan_study.report.illustrations import FIGURES, file_name, path_panels

WORST_DRAWN = 2
"""Worlds drawn of each headline: those where most is lost; the one where most is saved is beside them."""


@dataclass(frozen=True)
class Picture:
    """A figure as SVG, its file without the ending, and what it shows."""

    svg: str
    file: str
    words: str


@dataclass(frozen=True, eq=False)
class Material:
    """What the figures are drawn from."""

    folder: Path
    provenance: Mapping[str, Any]
    sources: Sequence[Source]
    runs: Runs
    impacts: Runs


def bounce_pictures(material: Material, results: BounceResults) -> Iterator[Picture]:
    """Draws them into figures/."""
    (material.folder / FIGURES).mkdir(exist_ok=True)
    both = (results.ours, results.against)
    against = " against ".join(both)
    if any(each.worlds for each in results.groups):
        drawn = draw_worlds(results.groups, *both)
        yield _saved(material, "by-world", drawn, f"Time saved world by world, {against}")
    headlines = [each for each in results.variants if each.group.headline]
    if headlines:
        yield _saved(material, "changes", draw_variants(headlines, *both), f"Time saved under each change, {against}")
    for each in results.groups:
        if each.group.headline and each.worlds:
            yield _worst(material, each, both)


def _worst(material: Material, found: GroupResults, both: tuple[str, str]) -> Picture:
    drawn = draw_paths([_panels(material, world, both) for world in _extremes(found)])
    words = f"{found.group.name}: where most is lost, and last where most is saved; circles: deliberate impacts"
    return _saved(material, f"paths-{found.group.name}", drawn, words)


def _extremes(found: GroupResults) -> list[str]:
    """The worlds where most is lost, then the one where most is saved."""
    worlds = [each.world for each in found.worlds]
    return list(dict.fromkeys([*worlds[:WORST_DRAWN], worlds[-1]]))


def _panels(material: Material, world: str, both: tuple[str, str]) -> list[PathPanel]:
    (source,) = (source for source in material.sources if source.world.name == world)
    (case,) = cases_of(material.runs.where(world=world, ablation=""))
    periods = [case.runs.where(strategy=strategy).distinct("map_period_s")[0] for strategy in both]
    cells = [{"strategy": name, "map_period_s": period} for name, period in zip(both, periods, strict=True)]
    hits = material.impacts.where(world=world, ablation="")
    deliberate = hits.kept(hits.columns["foreseen"] & (hits.columns["speed_into"] > DELIBERATE_SPEED))
    return path_panels(material.folder, material.provenance, source, case, cells, deliberate)


def _saved(material: Material, stem: str, figure: Figure, words: str) -> Picture:
    file = f"{FIGURES}/{file_name(stem)}"
    return Picture(save_figure(figure, material.folder / file), file, words)
