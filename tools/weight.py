"""Prints how much code there is by package: files, lines, and lines in function bodies, behind the docstring."""

import ast
import sys
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parents[1]
GROUPS = {"src": ["src"], "tests": ["tests"], "tools and others": ["tools", "benchmarks", "studies", "examples"]}


def body_lines(text: str) -> int:
    """Returns the number of lines in the bodies of a module's functions; those of an inner function count twice."""
    functions = (node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))
    return sum(_length(function) for function in functions)


def _length(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    body = function.body[1:] if ast.get_docstring(function, clean=False) is not None else function.body
    return (function.end_lineno or 0) - body[0].lineno + 1 if body else 0


def weight(folders: Sequence[Path]) -> tuple[int, int, int]:
    """Returns the number of Python files below folders, of their lines, and of lines in bodies."""
    texts = [path.read_text(encoding="utf-8") for folder in folders for path in folder.rglob("*.py")]
    return len(texts), sum(len(text.splitlines()) for text in texts), sum(map(body_lines, texts))


def main() -> int:
    """Prints the table of this checkout, or of one in a folder that is given."""
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT
    rows = {path.name: [path] for path in sorted((root / "src").iterdir()) if path.is_dir()}
    rows |= {name: [root / folder for folder in folders] for name, folders in GROUPS.items()}
    print(f"{'':18}{'files':>7}{'lines':>8}{'bodies':>8}")
    for name, folders in rows.items():
        files, lines, bodies = weight(folders)
        print(f"{name:18}{files:7}{lines:8}{bodies:8}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
