"""Commands to copy: a program of this project as it is started from where the user stands."""

import re
import sys
from pathlib import Path

PROGRAMS = re.compile(r"^  (bringup|study|beside|fit_robot|replay)\b", re.MULTILINE)


def as_called(program: str) -> str:
    """Returns how to call `program`: as it was typed, by its path beside this Python, or else by its name."""
    typed, beside = Path(sys.argv[0]), Path(sys.executable).with_name(program)
    if typed.name == program:
        return str(typed)
    return str(beside) if beside.exists() else program


def examples(text: str) -> str:
    """A help text whose lines of examples, two spaces and a program's name, start the program as it is called here."""
    return PROGRAMS.sub(lambda line: f"  {as_called(line[1])}", text)
