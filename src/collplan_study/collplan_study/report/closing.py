"""Values of the last sections of every report: runs that did not arrive, assumptions, origin of the numbers."""

from collections.abc import Mapping
from typing import Any

import polars as pl

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import all_specs
from collplan_core.parameters.spec import Spec
from collplan_study.tables.rows import axes_of

SHOWN = 100
"""Failed runs listed at most."""
PHYSICAL = ("robot", "rebound", "mocap", "simulator")
"""Groups of parameters that hold physical constants which a simulated run depends on."""


def closing_values(runs: pl.DataFrame, provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the values of the last sections of a study's page, from the rows of its runs and its provenance."""
    labels = ("world", "ablation", "strategy", "map_period_s", *axes_of(runs.columns), "trial", "seed")
    names = (*labels, "outcome", "path_length_m", "impacts", "share_stopped", "error")
    specs = [spec for spec in all_specs().values() if spec.key in provenance["parameters"]]
    return {
        "runs": runs.height,
        "failed": runs.filter(pl.col("outcome") != REACHED).select(names),
        "shown": SHOWN,
        "specs": specs,
        "assumed": list(filter(_is_assumed, specs)),
        "provenance": provenance,
    }


def _is_assumed(spec: Spec) -> bool:
    group, _, name = spec.key.partition(".")
    simulated = group == "simulator" and name not in ("world", "seed", "speed_factor")
    return simulated or (group in PHYSICAL and "(assumed" in spec.doc)
