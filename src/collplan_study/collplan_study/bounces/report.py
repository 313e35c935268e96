"""The report of a study of bounces: do deliberate bounces pay?"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from collplan_core.parameters import Settings
from collplan_study.bounces.pictures import bounce_pictures
from collplan_study.bounces.results import MAIN, BounceResults, bounce_results
from collplan_study.question.question import parse_axes
from collplan_study.report.content import Report, Section, markdown, with_interval
from collplan_study.report.study_data import StudyData
from collplan_study.report.templates import tables

LEAST = 6
"""Worlds listed of each headline group, those where least is saved."""

METHOD = (
    "Each pair of runs has the same world, the same noise and the same limits; t is the arrival time, and a run that "
    "does not arrive counts with the time limit. The time saved is 100 (1 - t / t_other) in percent, the mean over the "
    "worlds of the mean over a world's pairs; the mean of ratios is never kinder to the strategy that is judged than "
    "their geometric mean. Intervals are 95 % bootstrap intervals (BCa) over the worlds. Every strategy has the same "
    "map, candidates, time to go and refinement; they differ in what a contact does and costs, and in the stop test."
)


def bounce_report(data: StudyData) -> Report:
    """The report of a study."""
    results = bounce_results(data.provenance["question"]["strategies"], data.runs, data.impacts)
    counted = f"{data.runs.height} simulated runs of {data.provenance['trials']}. Nothing here was measured on a robot."
    opening = [Section("Do deliberate bounces pay?", counted, bullets=list(_summary(results)), level=1)]
    if results.groups:
        opening += [Section(note=_conditions(data.provenance)), Section(note=METHOD)]
    found = tables("bounce_tables.md", results=results, least=LEAST, main=MAIN) if results.groups else []
    commands = Section(
        note="All figures are simulated.", commands=[each["command"] for each in data.provenance["sessions"]]
    )
    document = markdown(commands, Section(bullets=opening[0].bullets), *opening[1:], *found)
    return Report(results.record(), _sections(data, results, opening, found), document)


def _sections(
    data: StudyData, results: BounceResults, opening: Sequence[Section], found: Sequence[Section]
) -> Iterator[Section]:
    yield from opening
    if not results.groups:
        return
    n = results.comparisons
    yield Section(
        note=f"{n} savings were compared: if nothing differed at all, about {0.05 * n:.1f} of their intervals would "
        "leave zero out. Intervals from fewer than some 15 worlds are too narrow."
    )
    yield from found
    yield Section("Figures")
    yield from (Section(picture=picture) for picture in bounce_pictures(data, results))


def _summary(results: BounceResults) -> Iterator[str]:
    """The savings of each headline group, a line for each."""
    for each in results.headlines:
        gains = ", ".join(f"{with_interval(gain.saved, 1, ' %')} against {gain.other}" for gain in each.gains)
        worlds = f"{len(each.worlds)} world{'' if len(each.worlds) == 1 else 's'}"
        yield f"{each.group.name}, {worlds}: {results.ours} saves {gains}."


def _conditions(provenance: Mapping[str, Any]) -> str:
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
