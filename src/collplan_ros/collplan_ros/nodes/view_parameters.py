"""What the nodes tell of their parameters, for the page to show, and the strategy, which it sets."""

from ast import literal_eval
from collections.abc import Collection, Mapping
from contextlib import suppress
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters

from collplan_ros.messages.status_values import values_of
from collplan_ros.node_kit.service_calls import ServiceCalls
from collplan_ros.view.server import Reply

STRATEGY = "planner.strategy"


class GraphParameters:
    """The parameters that nodes tell on shared_constants, latched and whenever one changes.

    Attributes:
        values: values by node, the newest told last, and by name.
    """

    def __init__(self, calls: ServiceCalls) -> None:
        self.values: dict[str, dict[str, object]] = {}
        self._calls = calls

    def take(self, message: DiagnosticStatus) -> None:
        """Takes what a node tells; a value that is none of Python's is left out."""
        told: dict[str, object] = {}
        for name, text in values_of(message).items():
            with suppress(ValueError, SyntaxError):
                told[name] = literal_eval(text)
        self.values.pop(str(message.name), None)
        self.values[str(message.name)] = told

    def choose(self, strategy: str, heard: Collection[str], reply: Reply) -> None:
        """Sets the strategy of the planner among the nodes that are heard, and replies with its answer."""
        planners = [node for node, values in self.values.items() if STRATEGY in values and node in heard]
        if not planners:
            reply(False, f"no node with {STRATEGY} was found")
            return

        def done(response: SetParameters.Response | None, trouble: str) -> None:
            if response is None:
                reply(False, trouble)
                return
            result = response.results[0]
            reply(bool(result.successful), str(result.reason) or f"{STRATEGY} is {strategy}")

        value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=strategy)
        request = SetParameters.Request(parameters=[Parameter(name=STRATEGY, value=value)])
        self._calls.soon(SetParameters, f"{planners[-1]}/set_parameters", request, done)


def first_of(values: Mapping[str, Mapping[str, object]], name: str) -> Any:
    """The value of a parameter in the first node that has it; None where none has."""
    return next((each[name] for each in values.values() if name in each), None)
