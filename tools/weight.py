"""Prints how much code there is by package, and fails where it is more than tools/weight.toml allows."""

import ast
import sys
from collections.abc import Sequence
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

from collplan_core.parameters import Settings

ROOT = Path(__file__).parents[1]
CEILING = Path(__file__).with_name("weight.toml")
GROUPS = {"src": ["src"], "tests": ["tests"], "rest": ["tools", "benchmarks", "studies", "examples"]}


def body_lines(text: str) -> int:
    """Returns the number of lines in the bodies of a module's functions; those of an inner function count twice."""
    functions = (node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))
    return sum(_length(function) for function in functions)


def _length(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    body = function.body[1:] if ast.get_docstring(function, clean=False) is not None else function.body
    return (function.end_lineno or 0) - body[0].lineno + 1 if body else 0


def weight(folders: Sequence[Path]) -> dict[str, int]:
    """Returns the number of Python files below folders, of their lines, and of lines in bodies."""
    texts = [path.read_text(encoding="utf-8") for folder in folders for path in folder.rglob("*.py")]
    lines = sum(len(text.splitlines()) for text in texts)
    return {"files": len(texts), "lines": lines, "bodies": sum(map(body_lines, texts))}


def weights() -> dict[str, dict[str, int]]:
    """Returns what each package, each group of folders and the list of parameters weigh."""
    rows = {path.name: [path] for path in sorted((ROOT / "src").iterdir()) if path.is_dir()}
    rows |= {name: [ROOT / folder for folder in folders] for name, folders in GROUPS.items()}
    found = {name: weight(folders) for name, folders in rows.items()}
    return found | {"parameters": {"number": len(Settings().values())}}


def too_heavy(found: dict[str, dict[str, int]], ceiling: dict[str, dict[str, int]]) -> list[str]:
    """Returns a line for each number that is above its ceiling."""
    return [
        f"{name}: {found[name][what]} {what}, expected at most {most}"
        for name, row in ceiling.items()
        for what, most in row.items()
        if found[name][what] > most
    ]


def main() -> int:
    """Prints the weights and what is too heavy."""
    found = weights()
    for name, row in found.items():
        print(f"{name:18}", *(f"{number:8} {what}" for what, number in row.items()))
    trouble = too_heavy(found, tomllib.loads(CEILING.read_text(encoding="utf-8")))
    print("\n".join(trouble) or f"none above {CEILING.name}")
    return 1 if trouble else 0


if __name__ == "__main__":
    sys.exit(main())
