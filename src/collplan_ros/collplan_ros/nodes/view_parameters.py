"""Parameters of the other nodes, for the page to show, and the strategy, which it sets."""

import time
from collections.abc import Mapping
from typing import Any

from rcl_interfaces.msg import Parameter, ParameterEvent, ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.parameter import parameter_value_to_python

from collplan_core.parameters.file import is_ros_key
from collplan_ros.node_kit.service_calls import ServiceCalls
from collplan_ros.view.scene import SILENT_AFTER
from collplan_ros.view.server import Reply

ASK_AGAIN, ASK_SOON = 4.0, 0.2
"""Time after which a node that did not answer, or has restarted, is asked again [s]."""
STRATEGY = "planner.strategy"


class GraphParameters:
    """The parameters of every node that reports, requested at its first report.

    Attributes:
        values: all parameters by node and name, of the nodes that have answered.
    """

    def __init__(self, calls: ServiceCalls) -> None:
        self.values: dict[str, dict[str, object]] = {}
        self._calls = calls
        self._asked: dict[str, float] = {}
        self._heard: dict[str, float] = {}
        self._numbers: dict[str, int] = {}

    def heard(self, node: str, number: int | None) -> None:
        """Notes a node's report; requests its parameters where it is new, has restarted, or has never answered.

        `number` is the number of the health report by its publisher, from 1; None where the middleware gives none.
        """
        now = time.monotonic()
        was_silent = now - self._heard.get(node, now) > SILENT_AFTER
        before = self._numbers.get(node, 0)
        has_started_again = number is not None and (number < before or number == before == 1)
        self._heard[node], self._numbers[node] = now, number or 0
        if was_silent or has_started_again:
            self.values.pop(node, None)
        since = now - self._asked.get(node, -ASK_AGAIN)
        if node not in self.values and since >= (ASK_SOON if has_started_again else ASK_AGAIN):
            self._asked[node] = now
            self._ask(node)

    def take_event(self, event: ParameterEvent) -> None:
        """Takes parameter values that were set."""
        for changed in event.changed_parameters:
            if changed.name in self.values.get(event.node, {}):
                self.values[event.node][changed.name] = parameter_value_to_python(changed.value)

    def choose(self, strategy: str, reply: Reply) -> None:
        """Sets the strategy of the planner that reported last, and replies with its answer."""
        planners = [node for node, values in self.values.items() if STRATEGY in values]
        if not planners:
            reply(False, f"no node with {STRATEGY} was found")
            return
        planner = max(planners, key=lambda node: self._heard[node])

        def done(response: SetParameters.Response | None, trouble: str) -> None:
            if response is None:
                reply(False, trouble)
                return
            result = response.results[0]
            if result.successful and planner in self.values:
                self.values[planner][STRATEGY] = strategy
            reply(bool(result.successful), str(result.reason) or f"{STRATEGY} is {strategy}")

        value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=strategy)
        request = SetParameters.Request(parameters=[Parameter(name=STRATEGY, value=value)])
        self._calls.soon(SetParameters, f"{planner}/set_parameters", request, done)

    def _ask(self, node: str) -> None:
        def listed(response: ListParameters.Response | None, _: str) -> None:
            if response is not None:
                names = [str(name) for name in response.result.names if not is_ros_key(name)]
                request = GetParameters.Request(names=names)
                self._calls.soon(GetParameters, f"{node}/get_parameters", request, lambda got, _: know(names, got))

        def know(names: list[str], response: GetParameters.Response | None) -> None:
            if response is not None:
                # none where one of them has no value
                values = map(parameter_value_to_python, response.values)
                self.values[node] = dict(zip(names, values, strict=False))

        self._calls.soon(ListParameters, f"{node}/list_parameters", ListParameters.Request(), listed)


def first_of(values: Mapping[str, Mapping[str, object]], name: str) -> Any:
    """The value of a parameter in the first node that has it; None where none has."""
    return next((each[name] for each in values.values() if name in each), None)
