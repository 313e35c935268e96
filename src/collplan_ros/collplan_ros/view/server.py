"""The page's server: files, and frames over a websocket, on this machine alone; in a thread of its own.

No client can hold up another, nor the graph: each has one slot, which the newest frame is merged into, and a time limit
for receiving it.
"""

import asyncio
import errno
import logging
import secrets
import socket
import threading
import time
from collections import deque
from collections.abc import Callable
from functools import partial
from http import HTTPStatus

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from collplan_ros.view import requests
from collplan_ros.view.frames import Newest, Texts, as_json, joined
from collplan_ros.view.requests import PageCommand

ADDRESS = "127.0.0.1"
"""The only address that is listened on."""
LARGEST_MESSAGE = 4096
"""Largest message of a client [bytes]."""
HANDSHAKE_PATIENCE = SEND_PATIENCE = 5.0
"""Time within which a connection must send its request, and a page must receive a frame [s]."""
SEND_BUFFER = 65536
"""Size of the system's send buffer of a page [bytes]: its content can no longer be merged."""
MOST_ANSWERS = 50
"""Answers kept for a page that does not receive them."""
POLICY_VIOLATION = 1008

Reply = Callable[[bool, str], None]
"""Sends the requesting page whether its command was done, and a message; may be called from any thread."""


class PortTaken(OSError):
    """The port cannot be listened on."""


def listening_socket(port: int) -> socket.socket:
    """A socket that listens on a port of this machine, 0 for any that is free; PortTaken: it cannot."""
    try:
        return socket.create_server((ADDRESS, port))
    except OSError as error:
        taken = error.errno == errno.EADDRINUSE
        why = "is taken by another program" if taken else f"cannot be listened on: {error.strerror or error}"
        raise PortTaken(f"view.port: {ADDRESS}:{port} {why}, expected a free port, as view.port {port + 1}") from None


class PageServer:
    """Serves the page from its construction until `close`."""

    def __init__(
        self, port: int, most_clients: int, take: Callable[[PageCommand, Reply], None], log: Callable[[str], None]
    ) -> None:
        """Listens on a port, 0 for any, or raises PortTaken; `take` runs in the server's thread, and must not wait."""
        self.token = secrets.token_urlsafe(32)
        """Each command must hold it; another one at each start."""
        self.n_clients = self.n_refused = 0
        """Numbers of open pages, and of refused requests and commands."""
        self._most_clients = most_clients
        self._take = take
        self._log = log
        self._files = requests.page_files(self.token)
        self._newest = Newest()
        self._clients: set[_Client] = set()
        self._left_at = -float("inf")
        self._socket = listening_socket(port)
        # every connection has that of the socket that listens
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
        self.port = int(self._socket.getsockname()[1])
        self._loop = asyncio.new_event_loop()
        self._end = asyncio.Event()
        self._thread = threading.Thread(
            target=self._loop.run_until_complete, args=(self._serve(),), name="page_server", daemon=True
        )
        self._thread.start()

    @property
    def address(self) -> str:
        """Address of the page."""
        return f"http://{ADDRESS}:{self.port}"

    def unwatched_for(self) -> float:
        """Time since the last page was closed [s]; 0 while one is open, infinite before the first."""
        return 0.0 if self.n_clients else time.monotonic() - self._left_at

    def publish(self, frame: Texts) -> None:
        """Sends a frame to all pages; may be called from any thread."""
        self._soon(self._publish, frame)

    def forget(self) -> None:
        """Forgets the frames so far; from any thread."""
        self._soon(self._newest.forget)

    def close(self) -> None:
        """Closes all pages and ends the thread."""
        self._soon(self._end.set)
        self._thread.join()
        self._loop.close()

    # ---- in the server's thread

    def _soon(self, act: Callable[..., object], *args: object) -> None:
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(act, *args)

    async def _serve(self) -> None:
        quiet = logging.getLogger("collplan.page")
        quiet.setLevel(logging.CRITICAL)  # the library logs a traceback for each bad request
        server = serve(
            self._welcome,
            sock=self._socket,
            process_request=self._process,
            compression=None,  # costs more than this machine's own wires gain
            max_size=LARGEST_MESSAGE,
            max_queue=4,
            open_timeout=HANDSHAKE_PATIENCE,
            close_timeout=1.0,
            server_header=None,
            logger=quiet,
        )
        async with server:
            await self._end.wait()

    def _process(self, _: ServerConnection, request: Request) -> Response | None:
        reply = requests.answer(request, self._files)
        if reply is None and len(self._clients) >= self._most_clients:
            reply = requests.refusal(HTTPStatus.SERVICE_UNAVAILABLE, "the largest number of pages is open")
        if reply is not None and reply.status_code >= 400:
            self._refuse(f"{reply.status_code} to {_seen(request)}: {reply.body.decode().strip()}")
        return reply

    def _refuse(self, words: str) -> None:
        self.n_refused += 1
        self._log(words)

    def _publish(self, frame: Texts) -> None:
        self._newest.add(frame)
        for client in self._clients:
            client.give(frame)

    async def _welcome(self, connection: ServerConnection) -> None:
        client = _Client(connection)
        self._clients.add(client)
        self.n_clients = len(self._clients)
        client.give(self._newest.whole())
        sender = asyncio.create_task(self._send(client))
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

    async def _send(self, client: "_Client") -> None:
        """Sends a page its frames until its connection ends, or it does not receive them in time."""
        try:
            while True:
                await client.news.wait()
                await asyncio.wait_for(client.send(), SEND_PATIENCE)
        except ConnectionClosed:
            pass
        except asyncio.TimeoutError:
            self._refuse(f"a page received nothing for {SEND_PATIENCE:g} s and is disconnected")
            client.connection.transport.abort()

    def _heard(self, client: "_Client", message: str | bytes) -> bool:
        """Acts on a message of a page; returns whether the page may stay."""
        try:
            command = requests.command_from_text(message, self.token)
        except requests.WrongToken:
            self._refuse("a command without the token of this start; nothing was done, and its connection is closed")
            return False
        except requests.CommandError as error:
            client.say(requests.number_of(message), False, str(error))
            return True
        self._take(command, partial(self._soon, client.say, command.number))
        return True


class _Client:
    """An open page and its next frame; `news` is set where there is one."""

    def __init__(self, connection: ServerConnection) -> None:
        self.connection = connection
        self.news = asyncio.Event()
        self._frame: Texts = {}
        self._answers: deque[str] = deque(maxlen=MOST_ANSWERS)

    def give(self, frame: Texts) -> None:
        """Queues a frame, merged into the one that a slow page has not received yet."""
        self._frame = {**self._frame, **frame}
        self.news.set()

    def say(self, number: int, done: bool, text: str) -> None:
        """Queues the answer to a command, before any frame."""
        self._answers.append(as_json({"answer": number, "done": done, "text": text}))
        self.news.set()

    async def send(self) -> None:
        """Sends the queued answers and frame."""
        self.news.clear()
        while self._answers:
            await self.connection.send(self._answers.popleft())
        frame, self._frame = self._frame, {}
        if frame:
            await self.connection.send(joined(frame))


def _seen(request: Request) -> str:
    """Returns the origin of a request, for the log: printable and short."""
    told = [f"{name} {value[:60]!r}" for name in ("Host", "Origin") for value in request.headers.get_all(name)[:2]]
    return f"{request.path[:60]!r} ({', '.join(told)})"
