"""Comparison of each call's outcome in a journal with its outcome now."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from collplan_core.replay.player import Player
from collplan_core.replay.reading import Beginning, Call, Event, Gap
from collplan_core.replay.values import outcome_of


@dataclass(frozen=True)
class Difference:
    """The first difference between a recording and its replay.

    Attributes:
        stamp: stamp of the newest pose then [s]; None before the first.
        where: keys that lead to the value.
        recorded, replayed: the value then and now.
    """

    stamp: float | None
    where: str
    recorded: Any
    replayed: Any

    def __str__(self) -> str:
        at = "before the first pose" if self.stamp is None else f"at {self.stamp:.3f} s"
        return f"{at}: {self.where}: {_shown(self.recorded)} recorded, {_shown(self.replayed)} replayed"


@dataclass(frozen=True)
class Interruption:
    """Interruption of a recording, which ends before the run did.

    Attributes:
        stamp: stamp of the newest pose before [s]; None before the first.
        reason: the missing part.
    """

    stamp: float | None
    reason: str

    def __str__(self) -> str:
        at = "before the first pose" if self.stamp is None else f"after {self.stamp:.3f} s"
        return f"a gap {at}: {self.reason}"


@dataclass(frozen=True)
class Comparison:
    """Comparison of a loop from its start on, as far as it was equal.

    Attributes:
        calls, plans, commands: numbers of equal ones.
        end: reason why the comparison ended early; None where it reached the end.
        beginning: inputs that the loop was made with; None where the beginning is missing.
    """

    calls: int = 0
    plans: int = 0
    commands: int = 0
    end: Difference | Interruption | None = None
    beginning: Beginning | None = None


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
