"""Start of an installed program: a module's `main`, imported only then."""

import signal
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from io import TextIOWrapper


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
        main = self.load()
        signal.signal(signal.SIGINT, on_ctrl_c)
        return main()
