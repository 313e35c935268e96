"""The parameters of the other nodes, as the page shows and sets them: by their own descriptions and ranges."""

import math
import time
from collections.abc import Callable, Mapping
from typing import Any

from rcl_interfaces.msg import Parameter, ParameterDescriptor, ParameterEvent, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.parameter import parameter_value_to_python

from collplan_core.parameters.file import is_ros_key
from collplan_ros.node_kit.service_calls import ServiceCalls
from collplan_ros.view.commands import Value
from collplan_ros.view.scene import SILENT_AFTER
from collplan_ros.view.server import Reply

ASK_AGAIN, ASK_SOON = 4.0, 0.2
"""Time after which a node that did not answer is asked again, and one that has started again is [s]."""
CHOICES = "one of "
"""How the constraint of a parameter with choices begins."""
KINDS = {
    ParameterType.PARAMETER_BOOL: "bool",
    ParameterType.PARAMETER_INTEGER: "int",
    ParameterType.PARAMETER_DOUBLE: "float",
    ParameterType.PARAMETER_STRING: "text",
    ParameterType.PARAMETER_DOUBLE_ARRAY: "list",
}
"""Kinds of parameters that the page knows."""


class GraphParameters:
    """The parameters of every node heard of, asked for once it is heard.

    Attributes:
        values: all parameters by node and name, of the nodes that have answered.
        live: those that may be set while the node runs, as the page is sent them, by node.
    """

    def __init__(self, calls: ServiceCalls) -> None:
        self.values: dict[str, dict[str, object]] = {}
        self.live: dict[str, list[dict[str, object]]] = {}
        self._calls = calls
        self._types: dict[tuple[str, str], int] = {}
        self._asked: dict[str, float] = {}
        self._heard: dict[str, float] = {}
        self._numbers: dict[str, int] = {}

    def heard(self, node: str, number: int | None) -> None:
        """Takes that a node is there; asks it where it is new, has come back or started again, or has never answered.

        `number` is which of its publisher's health reports was heard, from 1; None where the middleware does not tell.
        """
        now = time.monotonic()
        was_silent = now - self._heard.get(node, now) > SILENT_AFTER
        before = self._numbers.get(node, 0)
        has_started_again = number is not None and (number < before or number == before == 1)
        self._heard[node], self._numbers[node] = now, number or 0
        if was_silent or has_started_again:
            self.values.pop(node, None)
            self.live.pop(node, None)
        since = now - self._asked.get(node, -ASK_AGAIN)
        if node not in self.values and since >= (ASK_SOON if has_started_again else ASK_AGAIN):
            self._asked[node] = now
            self._ask(ListParameters, node, "list_parameters", ListParameters.Request(), self._listed)

    def take_event(self, event: ParameterEvent) -> None:
        """Takes new values that somebody has set."""
        for changed in event.changed_parameters:
            self._put(str(event.node), str(changed.name), parameter_value_to_python(changed.value))

    def set(self, node: str, name: str, value: Value, reply: Reply) -> None:
        """Sets a parameter, and says what the node has answered."""
        if not any(entry["name"] == name for entry in self.live.get(node, [])):
            reply(False, f"{node} has no live parameter {name}")
            return
        converted = _converted(self._types[node, name], value)
        if converted is None:
            reply(False, f"{name}: got {value!r}, expected another type")
            return

        def done(response: SetParameters.Response | None, trouble: str) -> None:
            if response is None:
                reply(False, trouble)
                return
            result = response.results[0]
            if result.successful:
                self._put(node, name, parameter_value_to_python(converted))
            reply(bool(result.successful), str(result.reason) or f"{name} is {value}")

        request = SetParameters.Request(parameters=[Parameter(name=name, value=converted)])
        self._calls.soon(SetParameters, f"{node}/set_parameters", request, done)

    # ---- asking

    def _ask(self, kind: type, node: str, service: str, request: Any, answered: Callable[[str, Any], None]) -> None:
        def done(response: Any, trouble: str) -> None:
            if response is not None:
                answered(node, response)

        self._calls.soon(kind, f"{node}/{service}", request, done)

    def _listed(self, node: str, response: ListParameters.Response) -> None:
        names = [name for name in response.result.names if not is_ros_key(name)]
        request = DescribeParameters.Request(names=names)
        self._ask(DescribeParameters, node, "describe_parameters", request, self._described)

    def _described(self, node: str, response: DescribeParameters.Response) -> None:
        descriptors = [each for each in response.descriptors if each.type in KINDS]

        def got(node: str, response: GetParameters.Response) -> None:
            values = [parameter_value_to_python(value) for value in response.values]
            self._know(node, descriptors, values)

        request = GetParameters.Request(names=[each.name for each in descriptors])
        self._ask(GetParameters, node, "get_parameters", request, got)

    def _know(self, node: str, descriptors: list[ParameterDescriptor], values: list[object]) -> None:
        self.values[node] = {str(each.name): value for each, value in zip(descriptors, values, strict=True)}
        self._types.update({(node, str(each.name)): int(each.type) for each in descriptors})
        self.live[node] = [
            entry_of(each, value) for each, value in zip(descriptors, values, strict=True) if not each.read_only
        ]

    def _put(self, node: str, name: str, value: object) -> None:
        if name in self.values.get(node, {}):
            self.values[node][name] = _plain(value)
            self.live[node] = [
                {**entry, "value": _plain(value)} if entry["name"] == name else entry for entry in self.live[node]
            ]


def entry_of(descriptor: ParameterDescriptor, value: object) -> dict[str, object]:
    """A parameter as the page is sent it: name, description, kind, value, range or choices."""
    constraints = str(descriptor.additional_constraints)
    ranges = [*descriptor.floating_point_range, *descriptor.integer_range]
    return {
        "name": str(descriptor.name),
        "doc": str(descriptor.description),
        "kind": KINDS[descriptor.type],
        "value": _plain(value),
        "low": _plain(ranges[0].from_value) if ranges else None,
        "high": _plain(ranges[0].to_value) if ranges else None,
        "choices": constraints[len(CHOICES) :].split(", ") if constraints.startswith(CHOICES) else [],
    }


def first_of(values: Mapping[str, Mapping[str, object]], name: str) -> Any:
    """The value of a parameter in the first node that has it; None where none has."""
    return next((each[name] for each in values.values() if name in each), None)


def _plain(value: Any) -> object:
    """A value as JSON knows it: a number that is not finite becomes text."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value if isinstance(value, (bool, int, float, str)) else [_plain(each) for each in value]


def _converted(kind: int, value: Value) -> ParameterValue | None:
    """A value as a parameter of a type; None where it is of another."""
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if kind == ParameterType.PARAMETER_BOOL and isinstance(value, bool):
        return ParameterValue(type=kind, bool_value=value)
    if kind == ParameterType.PARAMETER_INTEGER and is_number and float(value) == int(value):  # type: ignore[arg-type]
        return ParameterValue(type=kind, integer_value=int(value))  # type: ignore[arg-type]
    if kind == ParameterType.PARAMETER_DOUBLE and is_number:
        return ParameterValue(type=kind, double_value=float(value))  # type: ignore[arg-type]
    if kind == ParameterType.PARAMETER_STRING and isinstance(value, str):
        return ParameterValue(type=kind, string_value=value)
    if kind == ParameterType.PARAMETER_DOUBLE_ARRAY and isinstance(value, tuple):
        return ParameterValue(type=kind, double_array_value=list(value))
    return None
