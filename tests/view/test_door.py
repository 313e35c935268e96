"""Who is let in, by Host, Origin and where a request says it comes from; and what a browser is told."""

from http import HTTPStatus

from websockets.datastructures import Headers
from websockets.http11 import Request

from collplan_ros.view.requests import FRAMES, answer, page_files

PAGE = page_files("a-token")
OWN = {"host": "127.0.0.1:8090"}
SAME = {**OWN, "origin": "http://127.0.0.1:8090"}


def status(path="/", method="GET", **headers):
    named = Headers({name.replace("_", "-"): value for name, value in headers.items()})
    reply = answer(Request(path, named, method), PAGE)
    return None if reply is None else reply.status_code


def test_the_page_is_given_to_this_machine():
    for host in ("127.0.0.1:8090", "localhost:8090", "localhost:1234", "127.0.0.1", "localhost"):
        assert status(host=host) == HTTPStatus.OK, host
        assert status("/main.js", host=host, origin=f"http://{host}") == HTTPStatus.OK, host
        assert status(FRAMES, host=host, origin=f"http://{host}") is None, host
    assert status(FRAMES, **OWN) == HTTPStatus.FORBIDDEN


OTHER_HOSTS = [
    "", "evil.test:8090", "127.0.0.1.evil.test", "127.0.0.1:8090.evil.test", "0.0.0.0:8090", "[::1]:8090",
    "2130706433", "localhost:80:90", "user@127.0.0.1:8090",
]  # fmt: skip
OTHER_ORIGINS = [
    "http://evil.test", "null", "", "http://127.0.0.1", "http://127.0.0.1:3000", "https://127.0.0.1:8090",
    "http://localhost:8090", "http://127.0.0.1:8090/", "http://127.0.0.1:8090, http://evil.test",
]  # fmt: skip


def test_names_bound_to_this_machine_and_pages_of_other_origins_are_refused():
    for path in ("/", "/main.js", FRAMES):
        for host in OTHER_HOSTS:
            assert status(path, host=host, origin=f"http://{host}") == HTTPStatus.MISDIRECTED_REQUEST, (path, host)
        for origin in OTHER_ORIGINS:
            assert status(path, **OWN, origin=origin) == HTTPStatus.FORBIDDEN, (path, origin)


def test_parts_of_the_page_are_not_given_to_other_sites_but_a_link_may_lead_here():
    for site in ("cross-site", "same-site", "anything"):
        assert status("/main.js", **OWN, sec_fetch_site=site, sec_fetch_mode="no-cors") == HTTPStatus.FORBIDDEN, site
        assert status("/", **OWN, sec_fetch_site=site, sec_fetch_mode="no-cors") == HTTPStatus.FORBIDDEN, site
        assert status("/", **OWN, sec_fetch_site=site, sec_fetch_mode="navigate") == HTTPStatus.OK, site
    assert status("/", **OWN, sec_fetch_site="same-origin", sec_fetch_mode="cors") == HTTPStatus.OK


def test_other_files_are_not_there_and_other_methods_not_allowed():
    for path in ("/../door.py", "/page/main.js", "//", "/main.js?x", "/etc/passwd", "", "*", "/%2e/"):
        assert status(path, **SAME) == HTTPStatus.NOT_FOUND, path
    for method in ("POST", "PUT", "HEAD", "OPTIONS", "DELETE", "get"):
        assert status("/", method, **SAME) == status(FRAMES, method, **SAME) == HTTPStatus.METHOD_NOT_ALLOWED, method


def test_a_browser_keeps_everything_else_away_and_the_token_is_in_the_page_alone():
    for path in PAGE:
        reply = answer(Request(path, Headers(OWN)), PAGE)
        policy = dict(part.split(" ", 1) for part in reply.headers["Content-Security-Policy"].split("; "))
        assert policy == {
            "default-src": "'none'", "script-src": "'self'", "style-src": "'self'", "img-src": "'self' data:",
            "connect-src": "'self' ws://127.0.0.1:8090", "frame-ancestors": "'none'", "base-uri": "'none'",
            "form-action": "'none'",
        }  # fmt: skip
        assert reply.headers["X-Content-Type-Options"] == "nosniff"
        assert reply.headers["Cache-Control"] == "no-store"
        assert "Access-Control-Allow-Origin" not in reply.headers
        assert reply.headers["Content-Type"].split(";")[0] in ("text/html", "text/javascript", "text/css")
    assert {path for path, (_, content) in PAGE.items() if b"a-token" in content} == {"/", "/index.html"}
    assert not any(b"@TOKEN@" in content for _, content in PAGE.values())
