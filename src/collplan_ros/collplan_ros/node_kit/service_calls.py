"""Calls of services that may be missing: the caller gets an answer in any case, and never waits."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rclpy.client import Client
from rclpy.node import Node
from rclpy.task import Future

ANSWER_PATIENCE = 3.0
"""Longest wait for a service and its answer [s]."""

Done = Callable[[Any, str], None]
"""Takes the response and "", or None and the error."""


@dataclass(eq=False)
class _Call:
    client: Client
    request: Any
    done: Done
    deadline: float
    future: Future | None = None


class ServiceCalls:
    """Service calls of a node. Call `step` now and then, for calls that wait."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._kept: dict[str, Client] = {}
        self._pending: list[_Call] = []

    def keep(self, service_type: type, name: str) -> None:
        """Discovers a service from now on, so that a call of it need not wait for that."""
        self._kept[name] = self._node.create_client(service_type, name)

    def now(self, name: str, request: Any, done: Done) -> None:
        """Calls a kept service at once, or reports at once that no node offers it."""
        if self._kept[name].service_is_ready():
            self._call(name, request, done)
        else:
            done(None, f"no node offers {self._node.resolve_service_name(name)}")

    def soon(self, service_type: type, name: str, request: Any, done: Done) -> None:
        """Calls a service as soon as it is found."""
        if name not in self._kept:
            self.keep(service_type, name)
        self._call(name, request, done)

    def step(self) -> None:
        """Sends calls that waited for their service, and gives up those that waited too long."""
        for call in list(self._pending):
            if time.monotonic() > call.deadline:
                self._end(call, None, f"no answer from {call.client.srv_name} within {ANSWER_PATIENCE:g} s")
            else:
                self._send(call)

    def _call(self, name: str, request: Any, done: Done) -> None:
        call = _Call(self._kept[name], request, done, time.monotonic() + ANSWER_PATIENCE)
        self._pending.append(call)
        self._send(call)

    def _send(self, call: _Call) -> None:
        if call.future is None and call.client.service_is_ready():
            call.future = call.client.call_async(call.request)
            call.future.add_done_callback(lambda future: self._answered(call, future))

    def _answered(self, call: _Call, future: Future) -> None:
        error = future.exception()
        self._end(call, None if error else future.result(), f"{call.client.srv_name}: {error}" if error else "")

    def _end(self, call: _Call, response: Any, trouble: str) -> None:
        if call in self._pending:
            self._pending.remove(call)
            call.done(response, trouble)
