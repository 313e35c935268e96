"""What every node of the graph has: checked parameters, a local clock, shared constants, and health reports."""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.node import Node

from collplan_core.parameters import Settings
from collplan_ros.node_kit.clock import local_clock, seconds
from collplan_ros.node_kit.diagnostics import Diagnostics, Health
from collplan_ros.node_kit.inputs import Inputs
from collplan_ros.node_kit.node_parameters import Group, declare, on_change, read_settings
from collplan_ros.node_kit.shared_constants import SharedConstants


class GraphNode(Node):
    """A node whose constructor ends with `_begin`."""

    def __init__(
        self,
        name: str,
        groups: Sequence[Group],
        live: Sequence[Group] | None = None,
        check: Callable[[Settings], None] = lambda settings: None,
        **kwargs: Any,
    ) -> None:
        """Declares the parameters of `groups`, as `declare` does; keyword arguments go to `rclpy.node.Node`."""
        super().__init__(name, **kwargs)
        declare(self, *groups, live=live, check=check)
        self._settings = read_settings(self, *groups)  # present values of its groups; all others are at their defaults
        on_change(self, self._change, *groups)
        self._local_clock = local_clock(self)  # for its timers and ages
        self._constants = SharedConstants(self, self._settings, *groups)  # those that all nodes must share

    def _begin(self, inputs: Inputs | None = None) -> None:
        """Sends the first report: the node is ready. What `inputs` refuse and their conflicts are part of it."""

        def health() -> Health:
            refusals, conflicts = ({}, []) if inputs is None else (inputs.refusals.values, inputs.conflicts)
            return self._health().with_inputs(refusals, conflicts, self._constants.disagreement)

        self._diagnostics = Diagnostics(self, health)  # its health reports; from `_begin` on

    def _change(self, settings: Settings) -> None:
        """Takes settings that were changed by `ros2 param set`."""
        self._settings = settings

    def _local(self) -> float:
        """The time of the local clock [s]."""
        return seconds(self._local_clock)

    @abstractmethod
    def _health(self) -> Health:
        """The present health."""
