"""Writes the tables of docs/parameters.md, between its two markers, from the parameter groups.

    .venv/bin/python tools/parameter_table.py

Each parameter is written down once, in code; a test holds the page against it.
"""

from pathlib import Path

from collplan_core.parameters import GROUPS
from collplan_core.parameters.spec import Parameters, Spec, specs

PAGE = Path(__file__).parents[1] / "docs" / "parameters.md"
BEGIN, END = "<!-- tables: written by tools/parameter_table.py -->", "<!-- end of tables -->"


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


def _table(group: type[Parameters]) -> str:
    head = "| key | default | unit | range | live | what |\n|---|---|---|---|---|---|"
    rows = "\n".join(_row(spec) for spec in specs(group))
    return f"## {group.group}\n\n{group.__doc__}\n\n{head}\n{rows}"


def with_tables(page: str) -> str:
    """The text of the page with the tables between its markers as the code has them now."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    tables = "\n\n".join(_table(group) for group in GROUPS)
    return f"{before}{BEGIN}\n\n{tables}\n\n{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(with_tables(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
