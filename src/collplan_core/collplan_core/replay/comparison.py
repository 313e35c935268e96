"""A loop of planner or controller that replays a journal, and the comparison of each outcome with that of now."""

import json
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from collplan_core.deadline import Deadline, after_looks, never
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.parameters import Settings
from collplan_core.planners import first_memory
from collplan_core.replay.journal import PLANNER
from collplan_core.replay.reading import Beginning, Call, Event, Gap
from collplan_core.replay.values import JournalError, outcome_of
from collplan_core.state import State
from collplan_core.worlds.file import parse_text


class Player:
    """A loop, with the external answers recorded in a journal."""

    def __init__(self, of: str, beginning: Beginning) -> None:
        """Makes the loop anew, of PLANNER or CONTROLLER."""
        self.stamp: float | None = None  # stamp of the newest pose given to it [s]; None before the first
        self._forbidden: deque[str] = deque()
        self._looks: deque[int | None] = deque()
        settings = beginning.settings
        self.loop: PlannerLoop | ControllerLoop  # loop of the planner or the controller
        if of == PLANNER:
            text = beginning.known_map
            known_map = first_memory(settings, None if text is None else parse_text(text, "known_map", ""))
            self.loop = PlannerLoop(settings, self._deadline, known_map, self._why_forbidden)
        else:
            self.loop = ControllerLoop(settings, self._why_forbidden)

    def play(self, call: Call) -> Any:
        """Returns the outcome of a call of the loop, or the error that it raises.

        Raises:
            JournalError: the loop has no such input.
        """
        method = None if call.name.startswith("_") else getattr(self.loop, call.name, None)
        if not callable(method):
            raise JournalError(f"call: got {call.name!r}, expected an input of {type(self.loop).__name__}")
        self._forbidden, self._looks = deque(call.forbidden), deque(call.deadline_checks)
        if call.args and isinstance(call.args[0], State):
            self.stamp = call.args[0].stamp
        try:
            return method(*call.args)
        except Exception as error:  # an outcome as any other: the loop may have done so then
            return error

    def _why_forbidden(self) -> str:
        return self._forbidden.popleft() if self._forbidden else ""

    def _deadline(self, settings: Settings) -> Deadline:
        looks = self._looks.popleft() if self._looks else None
        return never if looks is None else after_looks(looks)


@dataclass(frozen=True)
class Difference:
    """The first difference between a recording and its replay."""

    stamp: float | None  # stamp of the newest pose then [s]; None before the first
    where: str  # keys that lead to the value
    recorded: Any  # recorded, replayed: the value then and now
    replayed: Any

    def __str__(self) -> str:
        at = "before the first pose" if self.stamp is None else f"at {self.stamp:.3f} s"
        return f"{at}: {self.where}: {_shown(self.recorded)} recorded, {_shown(self.replayed)} replayed"


@dataclass(frozen=True)
class Interruption:
    """Interruption of a recording, which ends before the run did."""

    stamp: float | None  # stamp of the newest pose before [s]; None before the first
    reason: str  # the missing part

    def __str__(self) -> str:
        at = "before the first pose" if self.stamp is None else f"after {self.stamp:.3f} s"
        return f"a gap {at}: {self.reason}"


@dataclass(frozen=True)
class Comparison:
    """Comparison of a loop from its start on, as far as it was equal."""

    calls: int = 0  # calls, plans, commands: numbers of equal ones
    plans: int = 0
    commands: int = 0
    end: Difference | Interruption | None = None  # reason why the comparison ended early; None where it reached the end
    beginning: Beginning | None = None  # inputs that the loop was made with; None where the beginning is missing


def compare(of: str, events: Iterable[Event]) -> Iterator[Comparison]:
    """Plays the journal of one loop; a comparison for each time that the loop was started.

    Raises:
        JournalError: the journal does not fit the loop.
    """
    done: Comparison | None = None
    player: Player | None = None
    for event in events:
        if isinstance(event, Beginning):
            if done is not None:
                yield done
            done, player = Comparison(beginning=event), Player(of, event)
            continue
        done = done or Comparison()
        if done.end is not None:
            continue
        if isinstance(event, Gap) or player is None:
            done = replace(done, end=Interruption(None if player is None else player.stamp, str(event)))
        else:
            done = _compared(done, player, event)
    if done is not None:
        yield done


def _compared(done: Comparison, player: Player, call: Call) -> Comparison:
    outcome = outcome_of(player.play(call))
    apart = first_apart(call.result, outcome, call.name)
    if apart is not None:
        return replace(done, end=Difference(player.stamp, *apart))
    decisions = outcome if isinstance(outcome, list) else [outcome]
    plans, commands = (sum(isinstance(each, dict) and tag in each for each in decisions) for tag in ("plan", "command"))
    return replace(done, calls=done.calls + 1, plans=done.plans + plans, commands=done.commands + commands)


def first_apart(recorded: Any, replayed: Any, where: str) -> tuple[str, Any, Any] | None:
    """Returns where two outcomes first differ, and the two values there; None where they are equal to the last bit."""
    if json.dumps(recorded) == json.dumps(replayed):
        return None
    if isinstance(recorded, dict) and isinstance(replayed, dict) and list(recorded) == list(replayed):
        pairs = [(f"{where}.{key}", recorded[key], replayed[key]) for key in recorded]
    elif isinstance(recorded, list) and isinstance(replayed, list) and len(recorded) == len(replayed):
        pairs = [(f"{where}[{k}]", a, b) for k, (a, b) in enumerate(zip(recorded, replayed, strict=True))]
    else:
        return where, recorded, replayed
    return next(apart for place, a, b in pairs if (apart := first_apart(a, b, place)))


def _shown(value: Any) -> str:
    text = value if isinstance(value, str) else json.dumps(value)
    return text if len(text) <= 300 else f"{text[:300]}..."
