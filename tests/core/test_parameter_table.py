"""The parameter tables of the documents are those of the code."""

import runpy
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_page_has_every_parameter_as_the_code_has_it():
    tool = runpy.run_path(str(ROOT / "tools" / "parameter_table.py"))
    page = (ROOT / "docs" / "parameters.md").read_text(encoding="utf-8")
    assert tool["with_tables"](page) == page, "run .venv/bin/python tools/parameter_table.py"
