"""What a browser asks of the live page, checked before anything is done: requests by their origin, then commands.

A page of another site, open in the same browser, can reach a server on this machine. It cannot choose the headers Host
and Origin, which the browser writes: a name that was bound to this machine's address stands in Host, the page's own
address in Origin. A command is one JSON object a message.
"""

import hmac
import json
from collections.abc import Mapping
from dataclasses import dataclass
from http import HTTPStatus
from importlib.resources import files
from typing import Any

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

FRAMES = "/frames"
"""Path of the websocket."""
OWN_NAMES = ("127.0.0.1", "localhost")
"""Names of this machine, as they stand in Host; with any port, as a tunnel may have another one at its near end."""
TYPES = {"html": "text/html", "js": "text/javascript", "css": "text/css", "svg": "image/svg+xml"}
TOKEN_MARK = b"@TOKEN@"
"""Placeholder in the page for the token of this start."""
HEADERS = {
    "Connection": "close",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; frame-ancestors 'none'; "
    "base-uri 'none'; form-action 'none'; connect-src "
)
"""What separates the page from other sites."""
ACTIONS = ("goal", "cancel", "resume", "estop", "clear_estop", "strategy")
GOAL, CANCEL, RESUME, STOP, CLEAR_STOP, CHOOSE = ACTIONS
LONGEST_TEXT = 200
"""Longest text in a command."""
LARGEST = 1e15
"""Largest number in a command; the nodes accept less."""


def page_files(token: str) -> dict[str, tuple[str, bytes]]:
    """Type and content of each file of the page, by path; index.html, which is also "/", holds the token."""
    found: dict[str, tuple[str, bytes]] = {}
    for entry in (files("collplan_ros.view") / "page").iterdir():
        kind = TYPES.get(entry.name.rpartition(".")[2])
        if kind is not None:
            found[f"/{entry.name}"] = (kind, entry.read_bytes().replace(TOKEN_MARK, token.encode()))
    found["/"] = found["/index.html"]
    return found


def answer(request: Request, page: Mapping[str, tuple[str, bytes]]) -> Response | None:
    """The answer to a request, from type and content of each file of the page; None lets a websocket in."""
    host, origins = _only(request.headers, "Host"), request.headers.get_all("Origin")
    if _name_of(host) not in OWN_NAMES:
        return refusal(HTTPStatus.MISDIRECTED_REQUEST, "this server answers to 127.0.0.1 and localhost alone")
    if origins not in ([], [f"http://{host}"]):
        return refusal(HTTPStatus.FORBIDDEN, "pages of other origins are not answered")
    site, mode = (_only(request.headers, f"Sec-Fetch-{name}") for name in ("Site", "Mode"))
    if site not in ("", "none", "same-origin") and mode not in ("", "navigate"):
        return refusal(HTTPStatus.FORBIDDEN, "parts of pages of other sites are not answered")
    # older releases of the library pass on GET alone, and do not say so
    if getattr(request, "method", "GET") != "GET":
        return refusal(HTTPStatus.METHOD_NOT_ALLOWED, "expected GET")
    if request.path == FRAMES:
        # a program that is no browser may leave the origin out; the page is not made for it
        return None if origins else refusal(HTTPStatus.FORBIDDEN, "expected an Origin")
    if request.path not in page:
        return refusal(HTTPStatus.NOT_FOUND, "no such file")
    return _response(HTTPStatus.OK, *page[request.path], host)


def refusal(status: HTTPStatus, words: str) -> Response:
    """Returns an answer with the reason of a refusal."""
    return _response(status, "text/plain", f"{words}\n".encode(), "")


def _response(status: HTTPStatus, kind: str, body: bytes, host: str) -> Response:
    """An answer that separates this page from other sites; the websocket has the same `host`."""
    # not every browser takes ws: for 'self'
    own = {"Content-Security-Policy": POLICY + (f"'self' ws://{host}" if host else "'none'")}
    about = {"Content-Type": f"{kind}; charset=utf-8", "Content-Length": str(len(body))}
    return Response(status.value, status.phrase, Headers({**about, **own, **HEADERS}), body)


def _only(headers: Headers, name: str) -> str:
    """The value of a header; empty where there is none, and an invalid name where there are several."""
    return ", ".join(headers.get_all(name))


def _name_of(host: str) -> str:
    """The name in a Host header; empty where what follows it is no port."""
    name, colon, port = host.partition(":")
    return name if not colon or (port.isascii() and port.isdecimal()) else ""


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

    @property
    def words(self) -> str:
        """What is asked, for a log."""
        place = f" ({self.at[0]:.2f}, {self.at[1]:.2f})" if self.action == GOAL else ""
        return self.action + (f" {self.strategy!r}" if self.strategy else place)


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
