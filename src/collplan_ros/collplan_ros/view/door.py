"""Who is let in: requests are answered by where they come from, before anything else is looked at.

A web page of anybody's, open in the same browser, can reach a server on this machine. It cannot choose the headers Host
and Origin, which the browser writes: a name that was bound to this machine's address stands in Host, the page's own
address in Origin.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from http import HTTPStatus
from importlib.resources import files
from typing import NamedTuple

FRAMES = "/frames"
"""Path of the websocket."""
OWN_NAMES = ("127.0.0.1", "localhost")
"""Names of this machine, as they stand in Host; with any port, as a tunnel may have another one at its near end."""
LOOKED_AT = ("host", "origin", "sec-fetch-site", "sec-fetch-mode")
"""Headers that tell where a request comes from."""
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
}
TOKEN_MARK = b"@TOKEN@"
"""Where the page has the token of this start."""


class Answer(NamedTuple):
    """An answer without a body of its own, or a file: status, headers, body."""

    status: HTTPStatus
    headers: dict[str, str]
    body: bytes


@dataclass(frozen=True)
class Request:
    """What is looked at of a request: of the headers LOOKED_AT those that it has."""

    method: str
    path: str
    headers: Mapping[str, str]


def page_files(token: str) -> dict[str, tuple[str, bytes]]:
    """Type and content of each file of the page, by path; index.html, which is also "/", holds the token."""
    found: dict[str, tuple[str, bytes]] = {}
    for entry in (files("collplan_ros.view") / "page").iterdir():
        kind = TYPES.get("." + entry.name.rpartition(".")[2])
        if kind is not None:
            found[f"/{entry.name}"] = (kind, entry.read_bytes().replace(TOKEN_MARK, token.encode()))
    found["/"] = found["/index.html"]
    return found


def answer(request: Request, page: Mapping[str, tuple[str, bytes]]) -> Answer | None:
    """The answer to a request; None lets a websocket in.

    Args:
        request: what is asked for.
        page: type and content of each file of the page, by path.
    """
    host = request.headers.get("host", "")
    if _name_of(host) not in OWN_NAMES:
        return _refusal(HTTPStatus.MISDIRECTED_REQUEST, "this server answers to 127.0.0.1 and localhost alone")
    origin = request.headers.get("origin")
    if origin not in (None, f"http://{host}"):
        return _refusal(HTTPStatus.FORBIDDEN, "pages of other origins are not answered")
    site, mode = request.headers.get("sec-fetch-site", "none"), request.headers.get("sec-fetch-mode", "navigate")
    if site not in ("none", "same-origin") and mode != "navigate":
        return _refusal(HTTPStatus.FORBIDDEN, "parts of pages of other sites are not answered")
    if request.method != "GET":
        return _refusal(HTTPStatus.METHOD_NOT_ALLOWED, "expected GET")
    if request.path == FRAMES:
        # what is no browser may leave the origin out; it is not who this page was made for
        return None if origin is not None else _refusal(HTTPStatus.FORBIDDEN, "expected an Origin")
    if request.path not in page:
        return _refusal(HTTPStatus.NOT_FOUND, "no such file")
    kind, content = page[request.path]
    return Answer(HTTPStatus.OK, {"Content-Type": kind, **_headers(host)}, content)


def full() -> Answer:
    """The answer where as many pages look as may."""
    return _refusal(HTTPStatus.SERVICE_UNAVAILABLE, "as many pages are open as may be: view.clients")


def _refusal(status: HTTPStatus, words: str) -> Answer:
    return Answer(status, {"Content-Type": "text/plain; charset=utf-8", **_headers("")}, f"{words}\n".encode())


def _headers(host: str) -> dict[str, str]:
    """What a browser is told to keep away from this page, and this page from others.

    Args:
        host: the Host that was asked for and found good; the websocket is at the same.
    """
    sources = {
        "default-src": "'none'",
        "script-src": "'self'",
        "style-src": "'self'",
        "img-src": "'self' data:",
        # not every browser takes ws: for 'self'
        "connect-src": f"'self' ws://{host}" if host else "'none'",
        "frame-ancestors": "'none'",
        "base-uri": "'none'",
        "form-action": "'none'",
    }
    return {
        "Content-Security-Policy": "; ".join(f"{name} {value}" for name, value in sources.items()),
        "X-Content-Type-Options": "nosniff",
        "X-Frame-Options": "DENY",
        "Referrer-Policy": "no-referrer",
        "Cross-Origin-Opener-Policy": "same-origin",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Cache-Control": "no-store",
    }


def _name_of(host: str) -> str:
    """The name in a Host header; empty where what follows it is no port."""
    name, colon, port = host.partition(":")
    return name if not colon or (port.isascii() and port.isdecimal()) else ""
