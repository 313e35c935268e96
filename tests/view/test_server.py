"""The server by real attempts over its socket: who gets in, what a page can do, and what it cannot do to others."""

import json
import socket
import time
from contextlib import ExitStack
from functools import partial

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from collplan_ros.view import server as server_module
from collplan_ros.view.frames import as_json
from collplan_ros.view.server import PageServer, PortTaken

PATIENCE = 20.0


class Bench:
    def __init__(self) -> None:
        self.commands = []
        self.lines = []
        self.server = PageServer(0, 20, self._take, self.lines.append)
        self.host = f"127.0.0.1:{self.server.port}"
        self.number = 0

    def _take(self, command, reply):
        self.commands.append(command)
        reply(True, f"{command.action} done")

    def page(self, stack: ExitStack, **options) -> ClientConnection:
        address, origin = f"ws://{self.host}/frames", f"http://{self.host}"
        return stack.enter_context(connect(address, origin=origin, compression=None, proxy=None, **options))

    def ask(self, page: ClientConnection, **command) -> None:
        self.number += 1
        page.send(json.dumps({"token": self.server.token, "number": self.number, **command}))

    def publish(self, **parts) -> None:
        self.number += 1
        self.server.publish({"t": as_json(float(self.number)), **{name: as_json(part) for name, part in parts.items()}})

    def raw(self, lines: list[str]) -> bytes:
        with socket.create_connection(("127.0.0.1", self.server.port), timeout=PATIENCE) as raw:
            raw.sendall("\r\n".join([*lines, "", ""]).encode())
            return b"".join(iter(partial(raw.recv, 65536), b""))

    def get(self, path: str) -> tuple[int, dict[str, str], bytes]:
        answer = self.raw([f"GET {path} HTTP/1.1", f"Host: {self.host}"])
        head, _, body = answer.partition(b"\r\n\r\n")
        first, *rest = head.decode().split("\r\n")
        return int(first.split()[1]), dict(line.lower().split(": ", 1) for line in rest), body


@pytest.fixture
def bench():
    bench = Bench()
    yield bench
    bench.server.close()


def wait_until(condition) -> bool:
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


def next_with(page: ClientConnection, name: str):
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        message = json.loads(page.recv(timeout=PATIENCE))
        if name in message:
            return message
    raise AssertionError(f"no {name}")


def ends(page: ClientConnection) -> int | None:
    try:
        while True:
            page.recv(timeout=PATIENCE)
    except ConnectionClosed as closed:
        return closed.rcvd.code if closed.rcvd else None


# ---- files


def test_the_page_and_its_files_are_served(bench):
    status, headers, body = bench.get("/")
    assert (status, int(headers["content-length"])) == (200, len(body))
    assert bench.server.token in body.decode()
    assert "frame-ancestors 'none'" in headers["content-security-policy"]


def test_other_requests_are_refused_and_the_server_goes_on(bench):
    for lines in (
        ["GET / HTTP/1.1"],
        ["GET / HTTP/1.1", "Host: evil.test", "Host: 127.0.0.1"],
        ["GET / HTTP/1.1", "Host: 127.0.0.1", "Origin: null", "Origin: http://127.0.0.1"],
        ["POST / HTTP/1.1", "Host: 127.0.0.1", "Content-Length: 5"],
        ["GET / HTTP/1.1", "Host: 127.0.0.1", "X: " + "x" * 9000],
        ["nonsense"],
    ):
        answer = bench.raw(lines)
        assert not answer.startswith(b"HTTP/1.1 200"), lines
        assert bench.server.token.encode() not in answer
        assert bench.get("/")[0] == 200
    assert bench.lines


# ---- the websocket


def test_a_page_gets_what_there_is_and_then_what_changes(bench):
    bench.publish(world={"name": "here"}, robot=[1, 2, 3, 4, 5])
    bench.publish(robot=[2, 2, 3, 4, 5])
    with ExitStack() as stack:
        page = bench.page(stack)
        first = json.loads(page.recv(timeout=PATIENCE))
        assert (first["world"], first["robot"]) == ({"name": "here"}, [2, 2, 3, 4, 5])
        assert [earlier["robot"][0] for earlier in first["history"]] == [1, 2]
        bench.publish(robot=[3, 2, 3, 4, 5])
        assert next_with(page, "robot")["robot"][0] == 3


def test_commands_arrive_and_are_answered(bench):
    with ExitStack() as stack:
        page = bench.page(stack)
        bench.ask(page, do="goal", x=1.0, y=2.0)
        assert next_with(page, "answer") == {"answer": 1, "done": True, "text": "goal done"}
        bench.ask(page, do="goal", x="here", y=2.0)
        answer = next_with(page, "answer")
        assert (answer["answer"], answer["done"]) == (2, False)
        assert answer["text"].startswith("x: got 'here'")
        bench.ask(page, do="estop")
        assert next_with(page, "answer")["done"]
    assert [command.action for command in bench.commands] == ["goal", "estop"]


def test_a_wrong_token_or_a_large_message_closes_the_page_and_nothing_is_done(bench):
    other = Bench()
    other.server.close()
    assert len(bench.server.token) >= 32
    tokens = ["", "wrong", None, other.server.token]
    wrong = [(json.dumps({"token": token, "number": 1, "do": "estop"}), 1008) for token in tokens]
    for message, code in (*wrong, ("x" * 5000, 1009), (b"\x00" * 5000, 1009)):
        with ExitStack() as stack:
            page, neighbour = bench.page(stack), bench.page(stack)
            page.send(message)
            assert ends(page) == code
            bench.ask(neighbour, do="resume")
            assert next_with(neighbour, "answer")["done"]
    assert {command.action for command in bench.commands} == {"resume"}
    assert any("token" in line for line in bench.lines)


# ---- many pages


def test_no_more_pages_than_may_be(bench):
    with ExitStack() as stack:
        pages = [bench.page(stack) for _ in range(20)]
        assert wait_until(lambda: bench.server.n_clients == 20)
        with pytest.raises(InvalidStatus) as refused:
            bench.page(stack)
        assert refused.value.response.status_code == 503
        pages[0].close()
        assert wait_until(lambda: bench.server.n_clients == 19)
        bench.page(stack)
    assert wait_until(lambda: bench.server.n_clients == 0)
    assert bench.server.unwatched_for() < PATIENCE


def test_a_page_that_stalls_is_dropped_and_harms_nobody(bench, monkeypatch):
    monkeypatch.setattr(server_module, "SEND_PATIENCE", 1.0)
    with ExitStack() as stack:
        page = bench.page(stack)
        # it takes nothing: its own end reads no more than its queue holds
        stalled = bench.page(stack, max_queue=1, ping_interval=None, close_timeout=0.1)
        assert wait_until(lambda: bench.server.n_clients == 2)
        end = time.monotonic() + PATIENCE
        large = list(range(10000))
        while bench.server.n_clients > 1 and time.monotonic() < end:
            bench.publish(robot=[bench.number], scan=large)
            assert next_with(page, "robot")
        assert bench.server.n_clients == 1, bench.lines
        bench.publish(robot=[-1])
        assert any(next_with(page, "robot")["robot"] == [-1] for _ in range(1000))
        bench.ask(page, do="estop")
        assert next_with(page, "answer")["done"]
        del stalled
    assert any("received nothing" in line for line in bench.lines)


def test_a_port_that_is_taken_is_named_and_no_other_address_is_listened_on(bench):
    with pytest.raises(PortTaken, match=rf"view.port.*127.0.0.1:{bench.server.port} .*{bench.server.port + 1}"):
        PageServer(bench.server.port, 20, lambda command, reply: None, print)
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.2", bench.server.port))


def test_it_ends_while_pages_are_open():
    bench = Bench()
    with ExitStack() as stack:
        page = bench.page(stack)
        bench.server.close()
        assert ends(page) == 1001
    bench.server.close()
    bench.server.publish({"t": "1.0"})
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.1", bench.server.port))
