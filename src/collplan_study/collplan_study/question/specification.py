"""The two questions that a study can ask: what tells one from the other, all in one place."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from collplan_core.strategies import PAPER_WEIGHTS
from collplan_study.question import bounces
from collplan_study.question.ablations import ABLATIONS
from collplan_study.question.ablations import DEFAULTS as ABLATION_DEFAULTS


@dataclass(frozen=True)
class Specification:
    """A question that the pipeline can ask: grid, trials, tables and report are the same for each.

    Attributes:
        defaults: parts of the question that the command line does not give.
        with_ablations: the same where ablations were asked for.
        map_periods: T_map [s] at which a strategy is run, by its name; others are run at their own.
        ablations: the named ablations that an engine can show.
        compares: whether strategies are compared with one another at one T_map and one value of each parameter.
        report: the function that makes its report, as MODULE:FUNCTION; it takes a second to import.
    """

    defaults: Mapping[str, Any]
    with_ablations: Mapping[str, Any]
    map_periods: Mapping[str, tuple[float, ...]]
    ablations: Callable[[str], Mapping[str, Mapping[str, Any]]]
    compares: bool
    report: str


PAPER = Specification(
    defaults={},
    with_ablations=ABLATION_DEFAULTS,
    map_periods=dict.fromkeys(PAPER_WEIGHTS, (0.2, 0.4, 0.6, 0.8, 1.0)),  # paper, IV-C
    ablations=lambda engine: ABLATIONS,
    compares=False,
    report="collplan_study.paper.report:paper_report",
)
"""Does harnessing collisions pay?"""
BOUNCES = Specification(
    defaults=bounces.DEFAULTS,
    with_ablations=bounces.DEFAULTS,
    map_periods={},
    ablations=bounces.variants_of,
    compares=True,
    report="collplan_study.bounces.report:bounce_report",
)
"""Do deliberate bounces pay?"""


def specification_of(is_of_bounces: bool) -> Specification:
    """The specification of a study with or without `--bounces`."""
    return BOUNCES if is_of_bounces else PAPER
