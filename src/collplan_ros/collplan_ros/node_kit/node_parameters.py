"""Parameter groups as ROS parameters of a node: declared, checked, read."""

from collections.abc import Callable, Collection, Sequence

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from collplan_core.parameters import Settings, all_specs, unknown_key
from collplan_core.parameters.file import is_ros_key
from collplan_core.parameters.groups import is_without_effect, without_effect
from collplan_core.parameters.spec import ParameterError, Parameters, Spec, specs

Group = type[Parameters] | str
"""A parameter group, or the key of the one parameter that a node reads of another node's group."""


def declare(
    node: Node,
    *groups: Group,
    live: Sequence[Group] | None = None,
    check: Callable[[Settings], None] = lambda settings: None,
) -> None:
    """Declares every parameter of these groups, with description, range and the node's overrides.

    From then on a value that does not fit is refused with the reason, and parameters that are not live are read-only.

    Args:
        live: of the live parameters of `groups`, those that this node takes while it runs; None for all. The others
            are read-only in this node: a value that is set and does nothing would mislead.
        check: raises ParameterError where values of these groups do not fit each other in this node.

    ParameterError: an override that does not fit its parameter, or whose key no group of the project has.
    """
    overrides = _overrides(node)
    taken = {spec.key for spec in specs_of(groups if live is None else tuple(live)) if spec.live}
    if words := without_effect(overrides):
        node.get_logger().warning(words)
    for key in overrides:
        if key not in all_specs() and not is_ros_key(key) and not is_without_effect(key):
            raise unknown_key(key)
    for spec in specs_of(groups):
        # checked here, not by rclpy: one wording everywhere, and a whole number will do for a float
        given = overrides.get(spec.key, spec.default)
        # ROS reads an empty list in a parameter file as nothing
        value = spec.checked(() if given is None and spec.default == () else given)
        node.declare_parameter(spec.key, value, _descriptor(spec, spec.key not in taken), ignore_override=True)
    check(read_settings(node, *groups))  # some values must fit each other
    floats = {spec.key for spec in specs_of(groups) if isinstance(spec.default, float)}
    node.add_pre_set_parameters_callback(lambda parameters: [_as_float(each, floats) for each in parameters])
    node.add_on_set_parameters_callback(lambda parameters: _verdict(node, groups, check, parameters))


def read_settings(node: Node, *groups: Group) -> Settings:
    """Settings with the present values of these declared groups; all other groups are at their defaults."""
    return Settings().with_values({spec.key: node.get_parameter(spec.key).value for spec in specs_of(groups)})


def on_change(node: Node, callback: Callable[[Settings], None], *groups: Group) -> None:
    """Calls `callback(settings)` after each accepted `ros2 param set` that touches one of these groups."""
    keys = {spec.key for spec in specs_of(groups)}

    def changed(parameters: list[Parameter]) -> None:
        if any(parameter.name in keys for parameter in parameters):
            callback(read_settings(node, *groups))

    node.add_post_set_parameters_callback(changed)


def specs_of(groups: tuple[Group, ...]) -> list[Spec]:
    """The `Spec` of each parameter of these groups."""
    known = all_specs()
    return [spec for group in groups for spec in ((known[group],) if isinstance(group, str) else specs(group))]


def _overrides(node: Node) -> dict[str, object]:
    """Parameters set by command line, parameter files and constructor; rclpy has no public list of them."""
    return {name: parameter.value for name, parameter in node._parameter_overrides.items()}  # noqa: SLF001


def _as_float(parameter: Parameter, floats: Collection[str]) -> Parameter:
    """Returns the parameter, a whole number for a float converted: `ros2 param set` sends 1 as an integer."""
    if parameter.name in floats and parameter.type_ == Parameter.Type.INTEGER:
        return Parameter(parameter.name, value=float(parameter.value))
    return parameter


def _verdict(
    node: Node, groups: tuple[Group, ...], check: Callable[[Settings], None], parameters: list[Parameter]
) -> SetParametersResult:
    ours = {spec.key for spec in specs_of(groups)}
    try:
        check(read_settings(node, *groups).with_values({p.name: p.value for p in parameters if p.name in ours}))
    except ParameterError as error:
        return SetParametersResult(successful=False, reason=str(error))
    return SetParametersResult(successful=True)


def _descriptor(spec: Spec, read_only: bool) -> ParameterDescriptor:
    unit = f" [{spec.unit}]" if spec.unit else ""
    descriptor = ParameterDescriptor(
        description=spec.doc + unit, additional_constraints=spec.expected, read_only=read_only
    )
    if spec.low is not None and spec.high is not None:
        if isinstance(spec.default, int):
            descriptor.integer_range = [IntegerRange(from_value=int(spec.low), to_value=int(spec.high), step=0)]
        else:
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=float(spec.low), to_value=float(spec.high), step=0.0)
            ]
    return descriptor
