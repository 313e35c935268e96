"""The fixture `ros`: a graph of its own for one test, in this process.

Nothing runs in the background: nodes, timers and callbacks advance while the test waits in `wait_until` or `spin`, in
the test's own thread, so a test reads what callbacks write without locks. A simulated robot whose speed_factor is 0
lets time pass pose by pose, once no node has anything left to do.
"""

import gc
import time
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

import pytest

N = TypeVar("N")
PATIENCE = 60.0
"""A condition that has not come true after this never will [s], also on a busy machine."""


class RosGraph:
    """Nodes of one test, and a probe that publishes to them and listens."""

    def __init__(self) -> None:
        import rclpy

        from collplan_ros.node_kit.events_executor import events_executor

        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self._executor = events_executor(self.context)
        self._nodes: list[Any] = []
        self._robot: Any = None
        self.probe = self.add(rclpy.create_node("probe", context=self.context))

    def add(self, node: N) -> N:
        """A node made in this graph's context, run from now on."""
        self._executor.add_node(node)
        self._nodes.append(node)
        return node

    def hold(self, node: Any) -> None:
        """Runs a node's callbacks no longer, as while one of them takes long."""
        self._executor.remove_node(node)

    def remove(self, node: Any) -> None:
        self._executor.remove_node(node)
        self._nodes.remove(node)
        if node is self._robot:
            self._robot = None
        # the executor lets go of it when what came before is done
        assert self.wait_until(self._executor.create_task(lambda: None).done)
        node.destroy_node()

    def forget_others(self) -> None:
        """Ends what earlier tests have left: a node that failed when it was made stays until it is collected.

        A probe of theirs may stay longer, with a client of an action. It says nothing.
        """
        gc.collect()
        assert self.wait_until(lambda: set(self.probe.get_node_names()) == {"probe"}), self.probe.get_node_names()

    def make(self, node_class: Callable[..., N], parameters: dict[str, object] | None = None, **kwargs: Any) -> N:
        """A node with these parameter overrides, run from now on."""
        from rclpy.parameter import Parameter

        overrides = [Parameter(name, value=value) for name, value in (parameters or {}).items()]
        node: Any = self.add(node_class(context=self.context, parameter_overrides=overrides, **kwargs))
        if not hasattr(node, "grant"):
            return node
        if node.get_parameter("simulator.speed_factor").value:
            node.start()
        else:
            self._robot = node
        return node

    def listen(self, message_type: type, topic: str, qos: Any = 10) -> list[Any]:
        """A list that grows by every message the probe receives."""
        messages: list[Any] = []
        self.probe.create_subscription(message_type, topic, messages.append, qos)
        return messages

    def publisher(
        self, message_type: type, topic: str, qos: Any = 10, matched: int = 1, timeout: float = PATIENCE
    ) -> Any:
        """A publisher of the probe, after `matched` listeners have found it."""
        publisher = self.probe.create_publisher(message_type, topic, qos)
        assert self.wait_until(lambda: publisher.get_subscription_count() >= matched, timeout), (
            f"no listener on {topic}"
        )
        return publisher

    def call(self, service_type: type, name: str, request: Any = None, timeout: float = PATIENCE) -> Any:
        client = self.probe.create_client(service_type, name)
        assert self.wait_until(client.service_is_ready, timeout), f"no service {name}"
        future = client.call_async(service_type.Request() if request is None else request)
        assert self.wait_until(future.done, timeout), f"no answer from {name}"
        return future.result()

    def wait_until(
        self, condition: Callable[[], Any], timeout: float = PATIENCE, clock: Callable[[], float] = time.monotonic
    ) -> bool:
        """Runs the nodes until the condition holds; whether it did within `timeout` [s] of `clock` [s].

        What takes longer on a busy machine is limited on the clock of the simulation, which a stall stops too.
        """
        end = clock() + timeout
        while not condition():
            if clock() > end:
                return False
            self._step()
        return True

    def _step(self) -> None:
        if self._robot is None:
            self._executor.spin_once(timeout_sec=0.02)
            return
        from collplan_ros.node_kit.events_executor import run_all_due

        self._robot.grant()
        while run_all_due(self._executor, self._nodes):
            pass

    def spin(self, duration: float) -> None:
        """Runs the nodes for so long [s]: to show that something does not happen."""
        self.wait_until(lambda: False, duration)

    def close(self) -> None:
        """In the order that leaves nothing behind."""
        self._executor.shutdown()
        for node in self._nodes:
            node.destroy_node()
        self.context.try_shutdown()


@pytest.fixture(scope="module")
def collected() -> Iterator[None]:
    """A node that failed when it was made stays in the domain until it is collected: it goes with its file.

    A graph that another file's test starts as processes would find it there, and refuse to start.
    """
    yield
    gc.collect()


@pytest.fixture
def ros(collected: None) -> Iterator[RosGraph]:
    graph = RosGraph()
    yield graph
    graph.close()
