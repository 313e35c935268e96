"""Calls of services that may not be there: answered in any case, and never waited for."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rclpy.client import Client
from rclpy.node import Node
from rclpy.task import Future

PATIENCE = 3.0
"""Longest wait for a service and its answer [s]."""

Done = Callable[[Any, str], None]
"""Takes the response and "", or None and what went wrong."""


@dataclass(eq=False)
class _Call:
    client: Client
    request: Any
    done: Done
    deadline: float
    future: Future | None = None


class ServiceCalls:
    """Calls from a node. `step` is to be called now and then, for those that wait."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._kept: dict[str, Client] = {}
        self._pending: list[_Call] = []

    def keep(self, service_type: type, name: str) -> None:
        """Looks for a service from now on, so that a call of it need not."""
        self._kept[name] = self._node.create_client(service_type, name)

    def now(self, name: str, request: Any, done: Done) -> None:
        """Calls a service that is kept at once, or says at once that nobody offers it."""
        client = self._kept[name]
        if not client.service_is_ready():
            done(None, f"nobody offers {self._node.resolve_service_name(name)}")
            return
        self._send(_Call(client, request, done, time.monotonic() + PATIENCE))

    def soon(self, service_type: type, name: str, request: Any, done: Done) -> None:
        """Calls a service as soon as it is found."""
        call = _Call(self._node.create_client(service_type, name), request, done, time.monotonic() + PATIENCE)
        if call.client.service_is_ready():
            self._send(call)
        else:
            self._pending.append(call)

    def step(self) -> None:
        """Sends what waited for its service, and gives up what has waited too long."""
        for call in list(self._pending):
            if time.monotonic() > call.deadline:
                self._end(call, None, f"no answer from {call.client.srv_name} within {PATIENCE:g} s")
            elif call.future is None and call.client.service_is_ready():
                self._pending.remove(call)
                self._send(call)

    def _send(self, call: _Call) -> None:
        self._pending.append(call)
        call.future = call.client.call_async(call.request)
        call.future.add_done_callback(lambda future: self._answered(call, future))

    def _answered(self, call: _Call, future: Future) -> None:
        if call not in self._pending:
            return
        error = future.exception()
        self._end(call, None if error else future.result(), f"{call.client.srv_name}: {error}" if error else "")

    def _end(self, call: _Call, response: Any, trouble: str) -> None:
        self._pending.remove(call)
        if call.client not in self._kept.values():
            self._node.destroy_client(call.client)
        call.done(response, trouble)
