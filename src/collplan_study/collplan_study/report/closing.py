"""The last sections of every report: runs that did not arrive, assumptions, origin of the numbers."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import polars as pl

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import all_specs
from collplan_core.parameters.spec import Spec
from collplan_study.report.content import Row, Section
from collplan_study.tables.rows import axes_of

SHOWN = 100
"""Failed runs listed at most."""
PHYSICAL = ("robot", "rebound", "mocap", "simulator")
"""Groups of parameters that hold physical constants which a simulated run depends on."""
PARAMETER_HEAD = ("parameter", "value", "meaning")
ASSUMED = (
    "The paper prints neither the robot's constants nor most of the planner's. These are assumed; what a world, an "
    "axis or an ablation sets otherwise is said where its numbers stand."
)
BESIDE = (
    "Beside this page: trials.parquet and .csv (a row a run), trajectories.parquet, impacts.parquet (a row an impact), "
    "table.json, provenance.json."
)


def closing_sections(runs: pl.DataFrame, provenance: Mapping[str, Any]) -> Iterator[Section]:
    """The last sections of a study's page, from the rows of its runs and its provenance."""
    yield _failures(runs)
    known, values, sessions = all_specs().values(), provenance["parameters"], provenance["sessions"]
    assumed = _parameter_rows(filter(_is_assumed, known), values)
    yield Section("What was assumed", ASSUMED, PARAMETER_HEAD, assumed, text=True)
    yield Section("Every parameter", head=PARAMETER_HEAD, rows=_parameter_rows(known, values), text=True, folded=True)
    rows = [
        ("asked", _listed({key: value for key, value in provenance["question"].items() if _text(value)})),
        ("code", _listed(provenance["code"])),
        ("versions", _listed(provenance["versions"])),
        ("machine", _listed(provenance["platform"])),
        ("begun", sessions[0]["begun"] if sessions else ""),
    ]
    commands = [session["command"] for session in sessions]
    yield Section("Where the numbers come from", head=("", ""), rows=rows, commands=commands, text=True)
    yield Section(note=BESIDE)


def _failures(runs: pl.DataFrame) -> Section:
    """The runs that did not arrive."""
    title, failed = "Runs that did not arrive", runs.filter(pl.col("outcome") != REACHED)
    if failed.is_empty():
        return Section(title, "None.")
    note = f"{failed.height} of {runs.height}" + (f", the first {SHOWN}:" if failed.height > SHOWN else ":")
    labels = ("world", "ablation", "strategy", "map_period_s", *axes_of(runs.columns), "trial", "seed")
    names = (*labels, "outcome", "path_length_m", "impacts", "share_stopped", "error")
    return Section(title, note, names, [tuple(map(_text, row)) for row in failed.select(names).head(SHOWN).iter_rows()])


def _is_assumed(spec: Spec) -> bool:
    group, _, name = spec.key.partition(".")
    simulated = group == "simulator" and name not in ("world", "seed", "speed_factor")
    return simulated or (group in PHYSICAL and "(assumed" in spec.doc)


def _parameter_rows(specs: Iterable[Spec], values: Mapping[str, Any]) -> list[Row]:
    return [
        (spec.key, f"{_text(values[spec.key])} {spec.unit}".strip(), spec.doc) for spec in specs if spec.key in values
    ]


def _listed(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{key}: {_text(value)}" for key, value in values.items())


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list | tuple):
        return " ".join(map(_text, value))
    return "" if value is None else str(value)
