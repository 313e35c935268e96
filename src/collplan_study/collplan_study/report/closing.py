"""The last sections of every report: runs that did not arrive, assumptions, origin of the numbers."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import polars as pl

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import all_specs
from collplan_core.parameters.spec import Spec
from collplan_study.report.content import Section
from collplan_study.report.templates import sections
from collplan_study.tables.rows import axes_of

SHOWN = 100
"""Failed runs listed at most."""
PHYSICAL = ("robot", "rebound", "mocap", "simulator")
"""Groups of parameters that hold physical constants which a simulated run depends on."""


def closing_sections(runs: pl.DataFrame, provenance: Mapping[str, Any]) -> Iterator[Section]:
    """The last sections of a study's page, from the rows of its runs and its provenance."""
    labels = ("world", "ablation", "strategy", "map_period_s", *axes_of(runs.columns), "trial", "seed")
    names = (*labels, "outcome", "path_length_m", "impacts", "share_stopped", "error")
    specs = [spec for spec in all_specs().values() if spec.key in provenance["parameters"]]
    failures, assumed, parameters, origin, beside = sections(
        "closing.md",
        runs=runs.height,
        failed=runs.filter(pl.col("outcome") != REACHED).select(names),
        shown=SHOWN,
        specs=specs,
        assumed=list(filter(_is_assumed, specs)),
        provenance=provenance,
    )
    commands = [session["command"] for session in provenance["sessions"]]
    yield failures
    yield replace(assumed, text=True)
    yield replace(parameters, text=True, folded=True)
    yield replace(origin, text=True, commands=commands)
    yield beside


def _is_assumed(spec: Spec) -> bool:
    group, _, name = spec.key.partition(".")
    simulated = group == "simulator" and name not in ("world", "seed", "speed_factor")
    return simulated or (group in PHYSICAL and "(assumed" in spec.doc)
