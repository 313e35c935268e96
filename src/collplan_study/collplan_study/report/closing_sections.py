"""The end of the report: runs that did not arrive, what was assumed, where the numbers come from."""

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Any

from collplan_core.parameters import all_specs
from collplan_core.parameters.spec import Spec
from collplan_study.analysis.runs import Runs, axes_of
from collplan_study.report.markup import folded, heading, paragraph, preformatted, table
from omnipuck_sim.trial import REACHED

SHOWN = 100
PHYSICAL = ("robot", "rebound", "mocap", "simulator")
"""Groups that hold constants of the robot and its surroundings which a simulated run depends on."""


def failure_section(runs: Runs) -> Iterator[str]:
    """The runs that did not arrive."""
    yield heading(2, "Runs that did not arrive")
    failed = runs.kept(runs.columns["outcome"] != REACHED)
    if not len(failed):
        yield paragraph("None.")
        return
    yield paragraph(f"{len(failed)} of {len(runs)}" + (f", the first {SHOWN}:" if len(failed) > SHOWN else ":"))
    names = ["world", "ablation", "strategy", "map_period_s", *axes_of(runs), "trial", "seed", "outcome",
             "path_length_m", "impacts", "share_stopped", "error"]  # fmt: skip
    rows = islice(failed.rows(*names), SHOWN)
    yield table(names, (tuple(map(_text, row.values())) for row in rows))


def assumed_section(provenance: Mapping[str, Any]) -> Iterator[str]:
    """The constants that nobody measured, then every parameter."""
    yield heading(2, "What was assumed")
    yield paragraph(
        "The paper prints neither the robot's constants nor most of the planner's. These are assumed; what a world, an "
        "axis or an ablation sets otherwise is said where its numbers stand."
    )
    known, values = all_specs(), provenance["parameters"]
    yield table(("parameter", "value", "meaning"), _parameters(filter(_is_assumed, known.values()), values), "text")
    changed = [(entry["world"], _listed(entry["values"])) for entry in provenance["sources"] if entry["values"]]
    if changed:
        yield heading(3, "Set by the rules of a world")
        yield table(("world", "parameters"), changed, "text")
    everything = table(("parameter", "value", "meaning"), _parameters(known.values(), values), "text")
    yield folded("Every parameter", everything)


def origin_section(provenance: Mapping[str, Any]) -> Iterator[str]:
    """Command, code, versions, machine."""
    yield heading(2, "Where the numbers come from")
    yield preformatted("\n".join(session["command"] for session in provenance["sessions"]))
    code, versions = provenance["code"], provenance["versions"]
    rows = [
        ("asked", _listed(provenance["question"])),
        ("code", _listed(code)),
        ("versions", _listed(versions)),
        ("machine", _listed(provenance["platform"])),
        ("begun", provenance["sessions"][0]["begun"] if provenance["sessions"] else ""),
    ]
    yield table(("", ""), rows, "text")
    beside = (
        "trials.parquet and .csv (a row a run), trajectories.parquet, impacts.parquet (a row an impact), table.json, "
        "provenance.json"
    )
    yield paragraph(f"Beside this page: {beside}.")


def _is_assumed(spec: Spec) -> bool:
    group, _, name = spec.key.partition(".")
    all_of_it = group == "simulator" and name not in ("world", "seed", "speed_factor")
    return all_of_it or (group in PHYSICAL and "(assumed" in spec.doc)


def _parameters(specs: Any, values: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    for spec in specs:
        if spec.key in values:
            yield spec.key, f"{_text(values[spec.key])} {spec.unit}".strip(), spec.doc


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
