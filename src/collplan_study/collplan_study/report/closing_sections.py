"""The last sections of every report: runs that did not arrive, assumptions, origin of the numbers."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from typing import Any

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import all_specs
from collplan_core.parameters.spec import Spec
from collplan_study.analysis.cases import axes_of
from collplan_study.analysis.rows import Rows
from collplan_study.report.content import Row, Table
from collplan_study.report.markup import folded, heading, paragraph, preformatted, section, table

SHOWN = 100
"""Failed runs listed at most."""
PHYSICAL = ("robot", "rebound", "mocap", "simulator")
"""Groups of parameters that hold physical constants which a simulated run depends on."""
PARAMETER_HEAD = ("parameter", "value", "meaning")


def failure_section(runs: Rows) -> Iterator[str]:
    """The runs that did not arrive."""
    title = "Runs that did not arrive"
    failed = runs.masked(runs.columns["outcome"] != REACHED)
    if not len(failed):
        yield from section(2, Table(title, "None."))
        return
    note = f"{len(failed)} of {len(runs)}" + (f", the first {SHOWN}:" if len(failed) > SHOWN else ":")
    labels = ("world", "ablation", "strategy", "map_period_s", *axes_of(runs), "trial", "seed")
    names = (*labels, "outcome", "path_length_m", "impacts", "share_stopped", "error")
    rows = [tuple(map(_text, row.values())) for row in islice(failed.dicts(*names), SHOWN)]
    yield from section(2, Table(title, note, names, rows))


def assumed_section(provenance: Mapping[str, Any]) -> Iterator[str]:
    """The assumed constants, then every parameter."""
    known, values = all_specs(), provenance["parameters"]
    yield from section(
        2,
        Table(
            "What was assumed",
            "The paper prints neither the robot's constants nor most of the planner's. These are assumed; what a "
            "world, an axis or an ablation sets otherwise is said where its numbers stand.",
            PARAMETER_HEAD,
            _parameter_rows(filter(_is_assumed, known.values()), values),
            text=True,
        ),
    )
    yield folded("Every parameter", table(PARAMETER_HEAD, _parameter_rows(known.values(), values), "text"))


def origin_section(provenance: Mapping[str, Any]) -> Iterator[str]:
    """Commands, code, versions and machine that the numbers come from."""
    sessions = provenance["sessions"]
    yield heading(2, "Where the numbers come from")
    yield preformatted("\n".join(session["command"] for session in sessions))
    rows = [
        ("asked", _listed(_said(provenance["question"]))),
        ("code", _listed(provenance["code"])),
        ("versions", _listed(provenance["versions"])),
        ("machine", _listed(provenance["platform"])),
        ("begun", sessions[0]["begun"] if sessions else ""),
    ]
    yield table(("", ""), rows, "text")
    beside = (
        "trials.parquet and .csv (a row a run), trajectories.parquet, impacts.parquet (a row an impact), table.json, "
        "provenance.json"
    )
    yield paragraph(f"Beside this page: {beside}.")


def _is_assumed(spec: Spec) -> bool:
    group, _, name = spec.key.partition(".")
    simulated = group == "simulator" and name not in ("world", "seed", "speed_factor")
    return simulated or (group in PHYSICAL and "(assumed" in spec.doc)


def _parameter_rows(specs: Iterable[Spec], values: Mapping[str, Any]) -> list[Row]:
    return [
        (spec.key, f"{_text(values[spec.key])} {spec.unit}".strip(), spec.doc) for spec in specs if spec.key in values
    ]


def _said(values: Mapping[str, Any]) -> dict[str, Any]:
    """The values that are not empty."""
    return {key: value for key, value in values.items() if _text(value)}


def _listed(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{key}: {_text(value)}" for key, value in values.items())


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return "" if value != value else f"{value:.6g}"
    if isinstance(value, list | tuple):
        return " ".join(map(_text, value))
    return "" if value is None else str(value)
