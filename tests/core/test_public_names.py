"""The names that programs of others import: none vanishes unseen, and none becomes public unseen."""

import ast
from importlib import import_module
from pathlib import Path

import pytest

from documents import ROOT, SOURCES, blocks

LIST = Path(__file__).with_name("public_names.txt")
LISTED = dict(line.split(": ") for line in LIST.read_text(encoding="utf-8").splitlines())
RULE = "docs/python.md#what-stays-as-it-is"


@pytest.mark.parametrize("module", LISTED)
def test_the_public_names_of_a_module_are_those_listed(module):
    listed = set(LISTED[module].split())
    here = import_module(module)
    offered = set(getattr(here, "__all__", listed & set(dir(here))))
    gone, new = sorted(listed - offered), sorted(offered - listed)
    assert not gone, (
        f"{module} lost {gone}: they stay for a minor version, with a warning ({RULE}); then strike them out"
    )
    assert not new, f"{module} offers {new}: add them to {LIST.name} if others may count on them ({RULE})"


def test_every_package_with_public_names_is_listed():
    packages = {path.split("/")[1] for path, source in SOURCES.items() if is_package(path) and "__all__ =" in source}
    assert packages <= LISTED.keys()


def test_pages_and_examples_import_public_names_alone():
    pages = [
        block
        for path in (*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"))
        for block in blocks(path.read_text(), "python")
    ]
    shown = {name for text in (*pages, *(p.read_text() for p in ROOT.glob("examples/*.py"))) for name in imported(text)}
    assert ("collplan_core", "Settings") in shown
    assert {(module, name) for module, name in shown if name not in LISTED.get(module, "").split()} == set()


def is_package(path: str) -> bool:
    parts = path.split("/")
    return parts[0] == "src" and len(parts) == 4 and parts[1] == parts[2] and parts[3] == "__init__.py"


def imported(source: str) -> set[tuple[str, str]]:
    nodes = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ImportFrom)]
    named = {(str(node.module), alias.name) for node in nodes for alias in node.names}
    return {(module, name) for module, name in named if f"src/{module.split('.')[0]}/setup.py" in SOURCES}
