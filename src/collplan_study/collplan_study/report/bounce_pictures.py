"""The pictures of a study of bounces."""

from collections.abc import Iterator

from collplan_study.analysis.bounce_results import BounceResults, GroupResults
from collplan_study.analysis.cases import cases_of
from collplan_study.report.bounce_figures import draw_variants, draw_worlds
from collplan_study.report.content import Picture
from collplan_study.report.figures import PathPanel, draw_paths
from collplan_study.report.pictures import path_panels, saved_picture
from collplan_study.report.study_data import StudyData

LEAST_DRAWN = 2
"""Worlds of each headline group whose paths are drawn because least is saved there; the one where most is follows."""


def bounce_pictures(data: StudyData, results: BounceResults) -> Iterator[Picture]:
    """Draws the pictures of a study and saves them."""
    both = (results.ours, results.against)
    against = " against ".join(both)
    if any(each.worlds for each in results.groups):
        drawn = draw_worlds(results.groups, *both)
        yield saved_picture(data, "by-world", drawn, f"Time saved world by world, {against}")
    headlines = [each for each in results.variants if each.group.headline]
    if headlines:
        drawn = draw_variants(headlines, *both)
        yield saved_picture(data, "changes", drawn, f"Time saved under each change, {against}")
    for each in results.groups:
        if each.group.headline and each.worlds:
            yield _extreme_paths(data, each, both)


def _extreme_paths(data: StudyData, found: GroupResults, both: tuple[str, str]) -> Picture:
    drawn = draw_paths([_panels(data, world, both) for world in _extremes(found)])
    words = f"{found.group.name}: where least is saved, and last where most is; circles: deliberate impacts"
    return saved_picture(data, f"paths-{found.group.name}", drawn, words)


def _extremes(found: GroupResults) -> list[str]:
    """The worlds where least is saved, then the one where most is."""
    worlds = [each.world for each in found.worlds]
    return list(dict.fromkeys([*worlds[:LEAST_DRAWN], worlds[-1]]))


def _panels(data: StudyData, world: str, both: tuple[str, str]) -> list[PathPanel]:
    (source,) = (source for source in data.sources if source.world.name == world)
    (case,) = cases_of(data.runs.where(world=world, ablation=""))
    periods = [case.runs.where(strategy=strategy).distinct("map_period_s")[0] for strategy in both]
    cells = [{"strategy": name, "map_period_s": period} for name, period in zip(both, periods, strict=True)]
    deliberate = data.impacts.where(world=world, ablation="", deliberate=True)
    return path_panels(data, source, case, cells, deliberate)
