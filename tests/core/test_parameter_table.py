"""The README's parameter tables are those of the code."""

import runpy
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_readme_has_every_parameter_as_the_code_has_it():
    tool = runpy.run_path(str(ROOT / "tools" / "parameter_table.py"))
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert tool["with_tables"](readme) == readme, "run .venv/bin/python tools/parameter_table.py"
