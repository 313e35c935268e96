"""How many tests hold a string of three words or more, and which files most; docstrings do not count."""

import ast
import re
from collections import Counter
from pathlib import Path

THREE_WORDS = re.compile(r"(?:[A-Za-z]+[,;:]? ){2}[A-Za-z]+")


def holds_prose(test: ast.FunctionDef) -> bool:
    """Whether a test, with its decorators, holds such a string."""
    body = test.body[1:] if ast.get_docstring(test) else test.body
    nodes = (node for part in [*test.decorator_list, *body] for node in ast.walk(part))
    texts = (node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str))
    return any(THREE_WORDS.search(text) for text in texts)


found: Counter[str] = Counter()
for path in sorted((Path(__file__).parents[1] / "tests").rglob("test_*.py")):
    functions = (node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.FunctionDef))
    found[path.name] += sum(test.name.startswith("test_") and holds_prose(test) for test in functions)
print(f"{found.total()} tests hold a string of three words or more")
print("\n".join(f"{count:4} {name}" for name, count in found.most_common(10)))
