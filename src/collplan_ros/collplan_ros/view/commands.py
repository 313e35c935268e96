"""Commands that a page may send: one JSON object a message, checked before anything is done."""

import hmac
import json
from dataclasses import dataclass
from typing import Any

ACTIONS = ("goal", "cancel", "resume", "estop", "clear_estop", "strategy")
GOAL, CANCEL, RESUME, STOP, CLEAR_STOP, CHOOSE = ACTIONS
LONGEST_TEXT = 200
"""Longest text in a command."""
LARGEST = 1e15
"""Largest number in a command; the nodes accept less."""


class WrongToken(Exception):
    """Error of a command without the token of this start: it is not from the page that was served."""


class CommandError(ValueError):
    """Error of a command that cannot be done; the text names the value and what was expected."""


@dataclass(frozen=True)
class PageCommand:
    """Command from a page."""

    number: int  # the page's own of it, for the answer
    action: str  # one of ACTIONS
    at: tuple[float, float] = (0.0, 0.0)  # goal position, of GOAL [m]
    strategy: str = ""  # to plan by, of CHOOSE


def command_from_text(text: str | bytes, token: str) -> PageCommand:
    """The command in a message.

    WrongToken: it has another token, or none, or is no such object at all. CommandError: it has the token, and no valid
    action.
    """
    try:
        given = json.loads(text)
    except (ValueError, RecursionError):
        raise WrongToken from None
    if not isinstance(given, dict) or not _is_token(given.get("token"), token):
        raise WrongToken
    number, action = given.get("number"), given.get("do")
    if type(number) is not int or not 0 <= number < 2**31:
        raise CommandError(f"number: got {_shown(number)}, expected a whole number from 0")
    if action not in ACTIONS:
        raise CommandError(f"do: got {_shown(action)}, expected one of {', '.join(ACTIONS)}")
    if action == GOAL:
        return PageCommand(number, action, at=(_coordinate(given, "x"), _coordinate(given, "y")))
    if action == CHOOSE:
        name = given.get("name")
        if not isinstance(name, str) or not 0 < len(name) <= LONGEST_TEXT:
            raise CommandError(f"name: got {_shown(name)}, expected that of a strategy")
        return PageCommand(number, action, strategy=name)
    return PageCommand(number, action)


def number_of(text: str | bytes) -> int:
    """The number of a command that was refused; 0 where it has none."""
    number = json.loads(text).get("number")
    return number if type(number) is int else 0


def _is_token(given: Any, token: str) -> bool:
    return isinstance(given, str) and hmac.compare_digest(given.encode(errors="replace"), token.encode())


def _coordinate(given: dict[str, Any], key: str) -> float:
    value = given.get(key)
    # compared, as a whole number may be too large for a float
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= LARGEST:
        raise CommandError(f"{key}: got {_shown(value)}, expected a number [m]")
    return float(value)


def _shown(value: Any) -> str:
    return repr(value)[:LONGEST_TEXT]
