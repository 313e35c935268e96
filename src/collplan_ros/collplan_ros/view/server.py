"""The page's server: files, and frames over a websocket, on this machine alone; in a thread of its own.

No client can hold up another, nor the graph: each has one slot, which the newest frame is merged into, a time in which
it must take what it is sent, and a rate at which it may speak.
"""

import asyncio
import logging
import secrets
import socket
import threading
import time
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.datastructures import Headers, MultipleValuesError
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request as HttpRequest
from websockets.http11 import Response
from websockets.server import ServerProtocol

from collplan_ros.view.allowance import Allowance
from collplan_ros.view.commands import CommandError, PageCommand, WrongToken, command_from_text, number_of
from collplan_ros.view.door import LOOKED_AT, Answer, Request, answer, full, page_files
from collplan_ros.view.frames import Newest, Slot, Texts, as_json, joined
from collplan_ros.view.listening import ADDRESS, listening_socket

LARGEST_MESSAGE = 4096
"""Largest message of a client [bytes]."""
MOST_WAITING = 40
"""Connections that may be open at once and have not, or not yet, become a page."""
HANDSHAKE_PATIENCE = 5.0
"""Time within which a connection must have said what it wants [s]."""
SEND_PATIENCE = 5.0
"""Time within which a page must take what it is sent [s]."""
COMMANDS_AT_ONCE, COMMANDS_A_SECOND = 20, 10.0
"""How many commands a page may send."""
BYTES_AT_ONCE, BYTES_A_SECOND = 65536, 16384.0
"""How much of anything, pings and headers among it, a connection may send."""
SEND_BUFFER = 65536
"""What the system keeps of what a page has not taken yet [bytes]: what is in it can be merged no more."""
MOST_ANSWERS = 50
"""Answers kept for a page that does not take them."""
LINES_AT_ONCE, LINES_A_SECOND = 20, 0.2
"""How many refusals are logged: nobody may fill a disk by being refused."""
POLICY_VIOLATION = 1008

Reply = Callable[[bool, str], None]
"""Tells the page that asked whether something was done, and what there is to say; from any thread."""


class PageServer:
    """Serves the page from its construction until `close`.

    Attributes:
        port: the port it listens on.
        token: what each command must hold, another one at each start.
        n_clients: pages that are open.
        n_refused: requests and commands that were refused.
    """

    def __init__(
        self, port: int, most_clients: int, take: Callable[[PageCommand, Reply], None], log: Callable[[str], None]
    ) -> None:
        """Listens, and starts the thread.

        Args:
            port: where; 0 for any that is free.
            most_clients: pages that may be open at once.
            take: does what a page has asked for; called in the server's thread, and must not wait.
            log: says at the terminal what was refused.

        Raises:
            PortTaken: it cannot listen there.
        """
        self.token = secrets.token_urlsafe(32)
        self.n_clients = self.n_refused = 0
        self._most_clients = most_clients
        self._take = take
        self._log = log
        self._lines = Allowance(LINES_AT_ONCE, LINES_A_SECOND)
        self._files = page_files(self.token)
        self._newest = Newest()
        self._clients: set[_Client] = set()
        self._waiting: set[_Connection] = set()
        self._left_at = -float("inf")
        self._socket = listening_socket(port)
        self.port = int(self._socket.getsockname()[1])
        self._loop = asyncio.new_event_loop()
        self._end = asyncio.Event()
        self._thread = threading.Thread(target=self._run, name="page_server", daemon=True)
        self._thread.start()

    @property
    def address(self) -> str:
        """Address of the page."""
        return f"http://{ADDRESS}:{self.port}"

    def unwatched_for(self) -> float:
        """Time since the last page was closed [s]; 0 while one is open, infinite before the first."""
        return 0.0 if self.n_clients else time.monotonic() - self._left_at

    def publish(self, frame: Texts) -> None:
        """Sends a frame to all pages; from any thread."""
        self._soon(self._publish, frame)

    def forget(self) -> None:
        """Forgets the frames so far; from any thread."""
        self._soon(self._newest.forget)

    def close(self) -> None:
        """Closes all pages and ends the thread."""
        self._soon(self._end.set)
        self._thread.join()

    # ---- in the server's thread

    def _soon(self, act: Callable[..., object], *args: object) -> None:
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(act, *args)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._serve())
        finally:
            self._loop.close()

    async def _serve(self) -> None:
        quiet = logging.getLogger("collplan.page")
        quiet.setLevel(logging.CRITICAL)  # the library logs a traceback for each bad request
        server = serve(
            self._welcome,
            sock=self._socket,
            process_request=self._process,
            create_connection=self._connection,  # type: ignore[arg-type]  # any factory will do
            compression=None,  # costs more than this machine's own wires gain
            max_size=LARGEST_MESSAGE,
            max_queue=4,
            open_timeout=HANDSHAKE_PATIENCE,
            close_timeout=1.0,
            server_header=None,
            logger=quiet,
        )
        async with server:
            while not self._end.is_set():
                self._drop_stalled()
                try:
                    await asyncio.wait_for(self._end.wait(), 1.0)
                except asyncio.TimeoutError:
                    continue

    def _connection(self, protocol: ServerProtocol, server: Server, **options: Any) -> "_Connection":
        return _Connection(self._waiting, self._refuse, protocol, server, **options)

    def _process(self, connection: ServerConnection, request: HttpRequest) -> Response | None:
        try:
            headers = {name: request.headers[name] for name in LOOKED_AT if name in request.headers}
        except MultipleValuesError:
            headers = {}
        asked = Request(getattr(request, "method", "GET"), request.path, headers)
        reply = answer(asked, self._files)
        if reply is None and len(self._clients) >= self._most_clients:
            reply = full()
        if reply is None:
            return None
        if reply.status >= 400:
            self._refuse(f"{reply.status.value} to {_seen(request)}: {reply.body.decode().strip()}")
        return _response(reply)

    def _refuse(self, words: str) -> None:
        self.n_refused += 1
        if self._lines.spend(1.0, time.monotonic()):
            self._log(words)

    def _publish(self, frame: Texts) -> None:
        self._newest.add(frame)
        for client in self._clients:
            client.give(frame)

    def _drop_stalled(self) -> None:
        for client in list(self._clients):
            if client.stalls():
                self._refuse(f"a page took nothing for {SEND_PATIENCE:g} s and is dropped")
                client.connection.transport.abort()

    async def _welcome(self, connection: ServerConnection) -> None:
        assert isinstance(connection, _Connection)
        self._waiting.discard(connection)
        client = _Client(connection)
        self._clients.add(client)
        self.n_clients = len(self._clients)
        client.give(self._newest.whole())
        sender = asyncio.create_task(client.send())
        try:
            async for message in connection:
                if not self._heard(client, message):
                    await connection.close(POLICY_VIOLATION)
                    break
        except ConnectionClosed:
            pass
        finally:
            sender.cancel()
            self._clients.discard(client)
            self._left_at = time.monotonic()
            self.n_clients = len(self._clients)

    def _heard(self, client: "_Client", message: str | bytes) -> bool:
        """Acts on a message of a page; whether the page may stay."""
        if not client.commands.spend(1.0, time.monotonic()):
            self._refuse("a page sent too many commands and is closed")
            return False
        try:
            command = command_from_text(message, self.token)
        except WrongToken:
            self._refuse("a command without the token of this start; nothing was done, and its connection is closed")
            return False
        except CommandError as error:
            client.say(number_of(message), False, str(error))
            return True
        self._take(command, partial(self._reply, client, command.number))
        return True

    def _reply(self, client: "_Client", number: int, done: bool, text: str) -> None:
        self._soon(client.say, number, done, text)


class _Connection(ServerConnection):
    """A connection that is turned away where too many wait, and cut where it sends too much."""

    def __init__(
        self,
        waiting: "set[_Connection]",
        refuse: Callable[[str], None],
        protocol: ServerProtocol,
        server: Server,
        **options: Any,
    ) -> None:
        super().__init__(protocol, server, **options)
        self._waiting = waiting
        self._refuse = refuse
        self._turned_away = False
        self._bytes = Allowance(BYTES_AT_ONCE, BYTES_A_SECOND)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        if len(self._waiting) >= MOST_WAITING:
            self._turned_away = True
            transport.abort()
            return
        self._waiting.add(self)
        transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
        super().connection_made(transport)

    def data_received(self, data: bytes) -> None:
        if self._bytes.spend(len(data), self.loop.time()):
            super().data_received(data)
        elif not self.transport.is_closing():
            self._refuse("a connection sent too much and is cut")
            self.transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        self._waiting.discard(self)
        if not self._turned_away:
            super().connection_lost(exc)


class _Client:
    """An open page: what it is sent next, and how much it may say."""

    def __init__(self, connection: ServerConnection) -> None:
        self.connection = connection
        self.commands = Allowance(COMMANDS_AT_ONCE, COMMANDS_A_SECOND)
        self._slot = Slot()
        self._answers: deque[str] = deque(maxlen=MOST_ANSWERS)
        self._news = asyncio.Event()
        self._sending_since: float | None = None

    def give(self, frame: Texts) -> None:
        """Has a frame sent as soon as there is room."""
        self._slot.put(frame)
        self._news.set()

    def say(self, number: int, done: bool, text: str) -> None:
        """Has the answer to a command sent, before any frame."""
        self._answers.append(as_json({"answer": number, "done": done, "text": text}))
        self._news.set()

    def stalls(self) -> bool:
        """Whether the page has not taken in time what it was sent."""
        return self._sending_since is not None and time.monotonic() - self._sending_since > SEND_PATIENCE

    async def send(self) -> None:
        """Sends what there is until the connection ends."""
        try:
            while True:
                await self._news.wait()
                self._news.clear()
                self._sending_since = time.monotonic()
                while self._answers:
                    await self.connection.send(self._answers.popleft())
                frame = self._slot.take()
                if frame:
                    await self.connection.send(joined(frame))
                self._sending_since = None
        except ConnectionClosed:
            pass


def _response(reply: Answer) -> Response:
    headers = Headers({**reply.headers, "Connection": "close", "Content-Length": str(len(reply.body))})
    return Response(reply.status.value, reply.status.phrase, headers, reply.body)


def _seen(request: HttpRequest) -> str:
    """Where a request came from, for the log: printable, and short."""
    told = [f"{name} {value[:60]!r}" for name in ("Host", "Origin") for value in request.headers.get_all(name)[:2]]
    return f"{request.path[:60]!r} ({', '.join(told)})"
