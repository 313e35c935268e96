"""Writes the parameter tables into README.md, between its two markers, from params.py.

    .venv/bin/python tools/parameter_table.py

Each parameter is written down once, in code; a test holds the README against it.
"""

from pathlib import Path

from collplan_core.parameters import GROUPS
from collplan_core.parameters.spec import Parameters, Spec, specs

README = Path(__file__).parents[1] / "README.md"
BEGIN, END = "<!-- parameters: written by tools/parameter_table.py -->", "<!-- end of parameters -->"


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
    return f"<details><summary><b>{group.group}</b>: {group.__doc__}</summary>\n\n{head}\n{rows}\n\n</details>"


def with_tables(readme: str) -> str:
    """The text of a README with the tables between its markers as the code has them now."""
    before, rest = readme.split(BEGIN)
    _, after = rest.split(END)
    tables = "\n\n".join(_table(group) for group in GROUPS)
    return f"{before}{BEGIN}\n\n{tables}\n\n{END}{after}"


if __name__ == "__main__":
    README.write_text(with_tables(README.read_text(encoding="utf-8")), encoding="utf-8")
