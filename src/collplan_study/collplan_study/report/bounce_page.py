"""The page of a study of bounces: do deliberate bounces pay?"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from collplan_core.parameters import Settings
from collplan_study.analysis.bounce_results import BounceResults
from collplan_study.question.axes import parse_axes
from collplan_study.report.bounce_tables import bounce_tables
from collplan_study.report.content import Picture, with_interval
from collplan_study.report.markup import bullets, figure, heading, paragraph, section

METHOD = (
    "Each pair of runs has the same world, the same noise and the same limits; t is the arrival time, and a run that "
    "does not arrive counts with the time limit. The time saved is 100 (1 - t / t_other) in percent, the mean over the "
    "worlds of the mean over a world's pairs; the mean of ratios is never kinder to the strategy that is judged than "
    "their geometric mean. Intervals are 95 % bootstrap intervals (BCa) over the worlds. Every strategy has the same "
    "map, candidates, time to go and refinement; they differ in what a contact does and costs, and in the stop test."
)


def bounce_page(
    results: BounceResults, provenance: Mapping[str, Any], pictures: Iterable[Picture], rows: int
) -> Iterator[str]:
    """HTML of the page but its closing sections.

    Args:
        results: results of the study.
        provenance: content of provenance.json.
        pictures: drawn as they are taken.
        rows: number of runs done so far.
    """
    yield heading(1, "Do deliberate bounces pay?")
    yield paragraph(f"{rows} simulated runs of {provenance['trials']}. Nothing here was measured on a robot.")
    if not results.groups:
        return
    yield bullets(summary(results))
    yield paragraph(conditions(provenance))
    yield paragraph(METHOD)
    yield paragraph(
        f"{results.comparisons} savings were compared: if nothing differed at all, about "
        f"{0.05 * results.comparisons:.1f} of their intervals would leave zero out. Intervals from fewer than some 15 "
        "worlds are too narrow."
    )
    for each in bounce_tables(results):
        yield from section(2, each)
    yield heading(2, "Figures")
    for picture in pictures:
        yield figure(picture)
        yield paragraph(f"{picture.words} ({picture.file}.png, .svg)", "quiet")


def summary(results: BounceResults) -> Iterator[str]:
    """The savings of each headline group, a line for each."""
    for each in results.groups:
        if each.group.headline:
            gains = ", ".join(f"{with_interval(gain.saved, 1, ' %')} against {gain.other}" for gain in each.gains)
            worlds = f"{len(each.worlds)} world{'' if len(each.worlds) == 1 else 's'}"
            yield f"{each.group.name}, {worlds}: {results.ours} saves {gains}."


def conditions(provenance: Mapping[str, Any]) -> str:
    """The assumed robot of the main comparison, without which no saving can be judged."""
    axes = parse_axes(provenance["question"]["values"])
    values = {**Settings().values(), **provenance["parameters"], **{key: value for key, (value,) in axes.items()}}
    return (
        f"Main comparison: engine {values['simulator.engine']}, a_max {values['robot.max_acceleration']:g} m/s^2, "
        f"v_max {values['robot.max_speed']:g} m/s, "
        f"restitution {values['simulator.restitution']:g} (believed {values['rebound.restitution']:g}), friction "
        f"{values['simulator.friction']:g} (believed {values['rebound.friction']:g}), "
        f"spread {values['simulator.restitution_spread']:g} and "
        f"{values['simulator.friction_spread']:g} from hit to hit, "
        f"noise {values['simulator.noise']:g}, all assumed."
    )
