"""Commands to copy: how to call a program of this project from the user's shell."""

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
    """Returns a help text whose example lines, two spaces and a program's name, call the program as it was called."""
    return PROGRAMS.sub(lambda line: f"  {as_called(line[1])}", text)
