"""Installed programs: how one is started, and how it is called from the user's shell."""

import argparse
import os
import re
import signal
import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from io import TextIOWrapper
from pathlib import Path

REFUSED = 2
"""Exit code of a program that cannot be imported."""
PROGRAMS = re.compile(r"^  (bringup|study|beside|replay|inspect)\b", re.MULTILINE)


def as_called(program: str) -> str:
    """Returns how to call `program`: as it was typed, by its path beside this Python, or else by its name."""
    typed, beside = Path(sys.argv[0]), Path(sys.executable).with_name(program)
    if typed.name == program:
        return str(typed)
    return str(beside) if beside.exists() else program


def examples(text: str) -> str:
    """Returns a help text whose example lines, two spaces and a program's name, call the program as it was called."""
    return PROGRAMS.sub(lambda line: f"  {as_called(line[1])}", text)


def parser_of(program: str, description: str, epilog: str, usage: str | None = None) -> argparse.ArgumentParser:
    """The parser of a program's command line, whose texts are laid out as they are, with examples as it was called."""
    form = argparse.RawDescriptionHelpFormatter
    return argparse.ArgumentParser(program, usage, description, examples(epilog), formatter_class=form)


@dataclass(frozen=True)
class Executable:
    """A program: `main` of a module.

    Its imports take a second or two; Ctrl-C while they last ends the process at once and without a traceback.
    """

    module: str

    def load(self) -> Callable[[], int]:
        """The module's `main`."""
        main: Callable[[], int] = import_module(self.module).main
        return main

    def __call__(self) -> int:
        """Runs the program; returns its exit code."""
        on_ctrl_c = signal.getsignal(signal.SIGINT)
        if on_ctrl_c is signal.default_int_handler:  # it may be ignored, as in the background of a shell
            signal.signal(signal.SIGINT, signal.SIG_DFL)
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, TextIOWrapper):  # a name that the terminal cannot show must not end the program
                stream.reconfigure(errors="backslashreplace")
        try:
            main = self.load()
        except (ImportError, SyntaxError, AttributeError, OSError) as error:
            if not (foreign := _foreign_folders(error)):
                raise
            which = f"PYTHONPATH holds {foreign}, of another Python or ROS? Unset it, or start a new shell"
            print(f"{Path(sys.argv[0]).name}: {' '.join(str(error).split())[:200]}: {which}", file=sys.stderr)
            return REFUSED
        signal.signal(signal.SIGINT, on_ctrl_c)
        return main()


def _foreign_folders(error: BaseException) -> str:
    """The folders of PYTHONPATH that an error at import came from, but for workspaces of these packages; "" if none."""
    paths = filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))
    folders = [each for each in paths if not any(Path(each).glob("collplan_*"))]
    named = str(getattr(error, "path", None) or getattr(error, "filename", None) or "")
    package = str(getattr(error, "name", None) or "").partition(".")[0]
    last = traceback.extract_tb(error.__traceback__)[-1].filename
    by_name = [each for each in folders if named.startswith(each) or (package and Path(each, package).exists())]
    return ", ".join(by_name or [each for each in folders if last.startswith(each)])
