"""Outcome of a loop's call, as JSON whose text is equal where the outcome is, to the last bit.

Large arrays are stored as hashes, values of interest to a reader as such.
"""

from collections.abc import Callable
from hashlib import blake2b
from typing import Any

import numpy as np

from collplan_core.command import Command
from collplan_core.goal import Goal
from collplan_core.loop.decisions import Cycle, Notice
from collplan_core.plan import Contacts
from collplan_core.replay.values import encode, little_endian

HASH_SIZE = 8
"""[bytes]"""


def outcome_of(value: Any) -> Any:
    """Returns the outcome of a call from the loop's return value or the error that it raised; None for None.

    Raises:
        TypeError: no loop returns such a thing.
    """
    if value is None or isinstance(value, str):
        return value or None
    if isinstance(value, list):
        return [outcome_of(each) for each in value] or None
    for kind, described in _DESCRIBED.items():
        if isinstance(value, kind):
            return described(value)
    raise TypeError(f"a journal holds no {type(value).__name__}")


def is_plan(outcome: Any) -> bool:
    """Returns whether one of a call's decisions is a plan."""
    return isinstance(outcome, list) and any(isinstance(each, dict) and "plan" in each for each in outcome)


def is_command(outcome: Any) -> bool:
    """Returns whether an outcome is a command."""
    return isinstance(outcome, dict) and "command" in outcome


def _hash(*arrays: np.ndarray) -> str:
    """BLAKE2b over arrays as little-endian float64, in hexadecimal digits."""
    digest = blake2b(digest_size=HASH_SIZE)
    for array in arrays:
        digest.update(little_endian(array))
    return digest.hexdigest()


def _command(command: Command) -> dict[str, Any]:
    return {
        "command": {
            "velocity": encode(command.velocity.tolist()),
            "yaw_rate": encode(command.yaw_rate),
            "maneuver": command.maneuver,
            "reference": encode(command.reference.tolist()),
            "reason": command.reason,
        }
    }


def _goal(goal: Goal) -> dict[str, Any]:
    return {"goal": encode([goal.id.hex(), goal.stamp, goal.position.tolist(), goal.status])}


def _cycle(cycle: Cycle) -> dict[str, Any]:
    plan = cycle.plan
    return {
        "plan": {
            "stamp": encode(plan.stamp),
            "valid_until": encode(plan.valid_until),
            "ends": encode(float(plan.times[-1])),
            "aim": encode(plan.aim.tolist()),
            "aim_velocity": encode(plan.aim_velocity.tolist()),
            "terms": {name: encode(float(value)) for name, value in plan.terms.items()},
            "samples": len(plan.times),
            "candidates": len(plan.candidates.costs),
            "before_pruning": int(plan.n_before_pruning),
            "contacts": _contacts(plan.contacts),
            "path": _hash(plan.times, plan.positions, plan.velocities),
        }
    }


def _contacts(contacts: Contacts) -> dict[str, Any]:
    every = _hash(contacts.times, contacts.points, contacts.velocities_after, contacts.speeds)
    return {"times": encode(contacts.times.tolist()), "all": every}


_DESCRIBED: dict[type, Callable[[Any], dict[str, Any]]] = {
    Command: _command,
    Goal: _goal,
    Cycle: _cycle,
    Notice: lambda notice: {"notice": [notice.level, notice.text]},
    Exception: lambda error: {"raised": f"{type(error).__name__}: {error}"},
}
