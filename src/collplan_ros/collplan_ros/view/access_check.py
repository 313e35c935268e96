"""Access check of the live page: requests are accepted by their origin, before anything else is read.

A page of another site, open in the same browser, can reach a server on this machine. It cannot choose the headers Host
and Origin, which the browser writes: a name that was bound to this machine's address stands in Host, the page's own
address in Origin.
"""

from collections.abc import Mapping
from http import HTTPStatus
from importlib.resources import files

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

FRAMES = "/frames"
"""Path of the websocket."""
OWN_NAMES = ("127.0.0.1", "localhost")
"""Names of this machine, as they stand in Host; with any port, as a tunnel may have another one at its near end."""
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
}
TOKEN_MARK = b"@TOKEN@"
"""Placeholder in the page for the token of this start."""


def page_files(token: str) -> dict[str, tuple[str, bytes]]:
    """Type and content of each file of the page, by path; index.html, which is also "/", holds the token."""
    found: dict[str, tuple[str, bytes]] = {}
    for entry in (files("collplan_ros.view") / "page").iterdir():
        kind = TYPES.get("." + entry.name.rpartition(".")[2])
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
    return _response(status, "text/plain; charset=utf-8", f"{words}\n".encode(), "")


def _response(status: HTTPStatus, kind: str, body: bytes, host: str) -> Response:
    """An answer with headers that separate this page from other sites; the websocket has the same `host`."""
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
    headers = {
        "Content-Type": kind,
        "Content-Length": str(len(body)),
        "Connection": "close",
        "Content-Security-Policy": "; ".join(f"{name} {value}" for name, value in sources.items()),
        "X-Content-Type-Options": "nosniff",
        "X-Frame-Options": "DENY",
        "Referrer-Policy": "no-referrer",
        "Cross-Origin-Opener-Policy": "same-origin",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Cache-Control": "no-store",
    }
    return Response(status.value, status.phrase, Headers(headers), body)


def _only(headers: Headers, name: str) -> str:
    """The value of a header; empty where there is none, and an invalid name where there are several."""
    return ", ".join(headers.get_all(name))


def _name_of(host: str) -> str:
    """The name in a Host header; empty where what follows it is no port."""
    name, colon, port = host.partition(":")
    return name if not colon or (port.isascii() and port.isdecimal()) else ""
