"""Writes the tables of docs/parameters.md, between its two markers, from the parameter groups.

    .venv/bin/python tools/parameter_table.py

Each parameter is written down once, in code; a test holds the page against it.
"""

from pathlib import Path

from collplan_core.parameters import GROUPS
from collplan_core.parameters.spec import Parameters, Spec, specs

PAGE = Path(__file__).parents[1] / "docs" / "parameters.md"
BEGIN, END = "<!-- tables: written by tools/parameter_table.py -->", "<!-- end of tables -->"

HEAD = "| key | default | unit | range | live | what |\n|---|---|---|---|---|---|"
SECTIONS = {
    "robot": "Robot, planners, controller, limits",
    "mocap": "Sensors and simulation",
    "kinematics": "Driver, firmware, live page, end of a run",
}
"""Title of the table that begins with this group."""


def _value(value: object) -> str:
    if isinstance(value, tuple):
        return "[" + ", ".join(map(_value, value)) + "]"
    return str(value).lower() if isinstance(value, bool) else f"{value:.6g}" if isinstance(value, float) else str(value)


def _range(spec: Spec) -> str:
    if spec.choices:
        return ", ".join(spec.choices)
    if spec.low is None and spec.high is None:
        return ""
    return " to ".join("" if bound is None else f"{bound:.6g}" for bound in (spec.low, spec.high))


def _row(spec: Spec) -> str:
    live = "live" if spec.live else ""
    return f"| `{spec.key}` | {_value(spec.default)} | {spec.unit} | {_range(spec)} | {live} | {spec.doc} |"


def _rows(group: type[Parameters]) -> str:
    head = f"\n## {SECTIONS[group.group]}\n\n{HEAD}\n" if group.group in SECTIONS else ""
    return head + "\n".join((f"| **{group.group}** | | | | | **{group.__doc__}** |", *map(_row, specs(group))))


def with_tables(page: str) -> str:
    """The text of the page with the tables between its markers as the code has them now."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    tables = "\n".join(map(_rows, GROUPS))
    return f"{before}{BEGIN}\n{tables}\n\n{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(with_tables(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
