"""The project as its documents see it: files, sources, and what these define."""

import ast
import re
from pathlib import Path

import yaml

from collplan_core.parameters import ParameterError, all_specs

ROOT = Path(__file__).parents[2]
FOLDERS = ("src", "docs", "tests", "tools", "benchmarks", ".ci")
FILES = {
    path.relative_to(ROOT).as_posix()
    for path in (*ROOT.glob("*"), *(path for folder in FOLDERS for path in (ROOT / folder).rglob("*")))
    if "__pycache__" not in path.parts
}
SOURCES = {path: (ROOT / path).read_text() for path in FILES if path.endswith(".py") and not path.startswith("tests/")}
EVERYTHING = "\n".join(SOURCES.values())
OF_THE_READER = {"lab.yaml", "floor.yaml", "spread.yaml", "my_arena.yaml", "my_room.yaml"}
CALLS = [node for source in SOURCES.values() for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call)]


def named_in_calls(*functions: str) -> set[str]:
    """The literal texts given to functions of these names, wherever in the sources."""
    calls = [call for call in CALLS if ast.unparse(call.func).split(".")[-1] in functions]
    given = [each.value for call in calls for each in call.args if isinstance(each, ast.Constant)]
    return {each for each in given if isinstance(each, str)}


NAMED = set(re.findall(r'^TOPIC = "([\w/]+)"', EVERYTHING, re.MULTILINE)) | {all_specs()["mocap.topic"].default}
TOPICS = named_in_calls("create_publisher", "create_subscription", "listen") | NAMED
SERVICES = named_in_calls("create_service", "_serve")


def found(path: str) -> list[str]:
    """The files and folders whose path ends so."""
    return [file for file in FILES if f"/{file}".endswith("/" + path.rstrip("/"))]


def is_there(path: str) -> bool:
    """Whether it is in the repository, written by the code, or the reader's own."""
    name = path.rstrip("/").split("/")[-1]
    written = path.startswith(("runs/", ".venv")) or f'"{name}"' in EVERYTHING
    return bool(found(path)) or written or name in OF_THE_READER


def source_of(module: str) -> str:
    path = f"src/{module.split('.')[0]}/{module.replace('.', '/')}"
    return SOURCES.get(f"{path}.py", "") or SOURCES.get(f"{path}/__init__.py", "")


def is_defined(name: str, source: str) -> bool:
    return bool(re.search(rf"^\s*(?:def|class) {name}\b|^{name}\b[^=\n]*=", source, re.MULTILINE))


def is_importable(name: str, source: str) -> bool:
    return is_defined(name, source) or name in {
        alias.name for node in ast.parse(source).body if isinstance(node, ast.ImportFrom) for alias in node.names
    }


def wrong_value(key: str, value: str | None, known: set[str] | None = None) -> list[str]:
    """What is wrong with a value of a parameter: the key is unknown, or it does not take the value."""
    if key not in (all_specs() if known is None else known):
        return [key]
    try:
        if value is not None:
            all_specs()[key].checked(yaml.safe_load(value))
    except ParameterError as error:
        return [str(error)]
    return []
