"""Writing of a journal: inputs of planner or controller, their outcome, and the code and machine that made it."""

import json
import platform
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numba
import numpy as np

from collplan_core.deadline import CountedDeadline, Deadline
from collplan_core.jit import sources_digest
from collplan_core.parameters import Settings
from collplan_core.replay.values import encode, outcome_of

PROCESSORS = Path("/proc/cpuinfo")


@cache
def origin() -> dict[str, str]:
    """Code and machine of this process, by name."""
    return {
        "code": sources_digest() + (", not compiled" if numba.config.DISABLE_JIT else ""),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": version("numba"),
        "scipy": version("scipy"),
        "shapely": version("shapely"),
        "processor": _processor(),
    }


def _processor() -> str:
    """The processor's model, of which compiled code makes use, or at least its kind."""
    try:
        models = [line for line in PROCESSORS.read_text().splitlines() if line.startswith("model name")]
    except OSError:
        models = []
    return models[0].partition(":")[2].strip() if models else platform.machine()


def changes(made_with: Mapping[str, object]) -> list[str]:
    """Returns the differences from a journal's origin, each as `numpy 1.26.4 then, 2.1.0 now`."""
    others = {name: now for name, now in origin().items() if made_with.get(name) != now}
    return [f"{name} {made_with.get(name)} then, {now} now" for name, now in others.items()]


PLANNER, CONTROLLER = "planner", "controller"
FORMAT = 6

P = ParamSpec("P")
R = TypeVar("R")


@dataclass
class _Call:
    """A call of the loop: its name, its arguments, the answers to its queries, and its outcome."""

    name: str
    args: tuple[Any, ...]
    forbidden: list[str] = field(default_factory=list)
    deadlines: list[CountedDeadline] = field(default_factory=list)
    result: Any = None


class Journal:
    """The journal of one loop, whose inputs all go through `call`.

    The answers to the loop's external queries are kept too: why it is forbidden to act, and how often it looked at its
    deadline before that passed, the only thing that a clock decides.
    """

    def __init__(self, of: str, send: Callable[[str], None] | None = None) -> None:
        """Hands each line of a loop, PLANNER or CONTROLLER, to `send`; without it nothing is kept or costs time."""
        self._of = of
        self._send = send
        self._number = 0
        self._calls: list[_Call] = []
        self._current: _Call | None = None

    def begin(self, settings: Settings, known_map: str | None = None) -> None:
        """Sends the first line: the settings that the loop is made with, and the text of the world given, if any."""
        self._write({"format": FORMAT, "made_with": origin(), "settings": encode(settings), "known_map": known_map})

    def call(self, method: Callable[P, R], *given: P.args, **named: P.kwargs) -> R:
        """Calls a method of the loop, and returns what it returns."""
        assert not named, "everything is given by its place"
        if self._send is None:
            return method(*given, **named)
        call = self._current = _Call(method.__name__, given)
        self._calls.append(call)
        try:
            result = call.result = method(*given, **named)
        except Exception as error:
            call.result = error
            raise
        finally:
            self._current = None
        return result

    def record_answers(self, why_forbidden: Callable[[], str]) -> Callable[[], str]:
        """Returns the same external query, whose answers are kept."""

        def asked() -> str:
            answer = why_forbidden()
            if self._current is not None:
                self._current.forbidden.append(answer)
            return answer

        return why_forbidden if self._send is None else asked

    def count_checks(self, make_deadline: Callable[[Settings], Deadline]) -> Callable[[Settings], Deadline]:
        """Wraps `make_deadline` so that the checks of each deadline are counted in the journal."""

        def counted(settings: Settings) -> Deadline:
            deadline = CountedDeadline(make_deadline(settings))
            if self._current is not None:
                self._current.deadlines.append(deadline)
            return deadline

        return make_deadline if self._send is None else counted

    def end_cycle(self) -> None:
        """Sends a line with all calls since the last one; without any none."""
        calls, self._calls = self._calls, []
        if calls:
            self._write({"calls": [_entry(call) for call in calls]})

    def _write(self, line: Mapping[str, Any]) -> None:
        if self._send is not None:
            self._send(json.dumps({"number": self._number, "of": self._of, **line}, separators=(",", ":")))
            self._number += 1


def _entry(call: _Call) -> dict[str, Any]:
    entry = {"call": call.name, "args": encode(call.args)}
    if any(call.forbidden):
        entry["forbidden"] = call.forbidden
    checks = [deadline.looks if deadline.came else None for deadline in call.deadlines]
    if any(count is not None for count in checks):
        entry["deadline_checks"] = checks
    result = outcome_of(call.result)
    return entry if result is None else {**entry, "result": result}
