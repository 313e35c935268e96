"""Parameters of nodes: declared from the groups, checked, live or not."""

import pytest
import rclpy
from rcl_interfaces.srv import DescribeParameters, SetParameters
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from terminal import Terminal

from collplan_core.parameters import GROUPS, Limits, Mocap, Robot, Settings
from collplan_core.parameters.file import read_parameters, write_values
from collplan_core.parameters.spec import ParameterError, specs
from collplan_ros.node_kit.node_parameters import declare, on_change, read_settings


class Declaring(Node):
    def __init__(self, groups=(Robot, Mocap), **kwargs):
        super().__init__("declaring", **kwargs)
        declare(self, *groups)


def test_every_parameter_says_what_it_is_and_has_its_default(ros):
    node = ros.make(lambda **kwargs: Declaring(GROUPS, **kwargs))
    assert read_settings(node, *GROUPS) == Settings()
    for spec in (spec for group in GROUPS for spec in specs(group)):
        descriptor = node.describe_parameter(spec.key)
        assert descriptor.description.startswith(spec.doc)
        assert descriptor.read_only == (not spec.live)
        bounds = [*descriptor.integer_range, *descriptor.floating_point_range]
        assert [(b.from_value, b.to_value) for b in bounds] == ([] if spec.low is None else [(spec.low, spec.high)])


def test_overrides_are_read_and_those_of_other_nodes_are_ignored(ros):
    values = {"robot.radius": 0.2, "mocap.detect_impacts": False, "robot.max_speed": 1}
    node = ros.make(Declaring, {**values, "planner.map_period": 0.3, "use_sim_time": False})
    assert not node.has_parameter("planner.map_period")
    assert read_settings(node, Robot, Mocap) == Settings().with_values({**values, "robot.max_speed": 1.0})
    request = DescribeParameters.Request(names=["robot.max_speed"])
    (descriptor,) = ros.call(DescribeParameters, "/declaring/describe_parameters", request).descriptors
    assert descriptor.floating_point_range[0].to_value == 5.0


BAD_OVERRIDES = (
    ("robot.max_sped", 1.0, "robot.max_speed"),
    ("qos_overrides./plan.publisher.depth", 9, "has no effect"),
    ("robot.max_speed", 99.0, r"99\.0.*\[0\.05, 5\]"),
    ("mocap.detect_impacts", 1, "true or false"),
)


def test_overrides_that_do_not_fit_are_errors(ros):
    for key, value, words in BAD_OVERRIDES:
        with pytest.raises(ParameterError, match=words) as error:
            ros.make(Declaring, {key: value})
        assert key in str(error.value)


def set_on(ros, key, value):
    request = SetParameters.Request(parameters=[Parameter(key, value=value).to_parameter_msg()])
    return ros.call(SetParameters, "/declaring/set_parameters", request).results[0]


def test_live_parameter_can_be_set_and_is_noticed(ros):
    node = ros.make(Declaring)
    seen = []
    on_change(node, seen.append, Robot)
    assert set_on(ros, "robot.max_speed", 0.5).successful
    assert [s.robot.max_speed for s in seen] == [0.5]
    assert read_settings(node, Robot, Mocap).robot.max_speed == 0.5
    assert set_on(ros, "mocap.leap_margin", 0.1).successful
    assert len(seen) == 1
    assert set_on(ros, "robot.max_speed", 1).successful
    assert read_settings(node, Robot, Mocap).robot.max_speed == 1.0


def test_sets_that_are_rejected_say_why_and_change_nothing(ros):
    node = ros.make(Declaring)
    seen = []
    on_change(node, seen.append, Robot)
    for key, value, words in (
        ("robot.max_speed", float("nan"), "value: nan"),
        ("robot.max_speed", "fast", "type"),
        ("robot.radius", 0.2, "read-only"),
    ):
        answer = set_on(ros, key, value)
        assert not answer.successful, value
        assert words in answer.reason
    assert read_settings(node, Robot, Mocap) == Settings()
    assert not seen


def test_a_list_of_a_parameter_file_is_read_an_empty_one_too(ros, tmp_path):
    path = tmp_path / "lab.yaml"
    arguments = ["--ros-args", "--params-file", str(path)]
    for fence in ((), (0.0, 0.0, 2.0, 0.0, 2.0, 1.5)):
        write_values({"limits.fence": list(fence)}, path)
        node = ros.make(lambda **kwargs: Declaring((Limits,), cli_args=arguments, **kwargs))
        assert read_settings(node, Limits).limits.fence == fence


def test_removed_parameters_in_a_node_s_file_are_named_and_nothing_else(ros, tmp_path):
    terminal, path = Terminal(ros), tmp_path / "lab.yaml"
    write_values({"teleop.deadzone": 0.2, "robot.radius": 0.1}, path)
    node = ros.make(lambda **kwargs: Declaring(cli_args=["--ros-args", "--params-file", str(path)], **kwargs))
    assert read_settings(node, Robot, Mocap).robot.radius == 0.1
    assert terminal.has(node, "teleop.deadzone: no longer a parameter, has no effect")


def test_ros_reads_every_text_that_is_written_as_text(tmp_path):
    path = tmp_path / "written.yaml"
    for text in ("y", "nan", "08", "1e5", "~", "on", "1:30", "0x10", "\u00fc # :", 'it\'s "so"', "2026-01-01", "true"):
        write_values({"mocap.subject": text}, path)
        context = Context()
        rclpy.init(args=["--ros-args", "--params-file", str(path)], context=context)
        try:
            node = rclpy.create_node("reader", context=context, automatically_declare_parameters_from_overrides=True)
            assert node.get_parameter("mocap.subject").value == text
            node.destroy_node()
        finally:
            context.try_shutdown()
        assert read_parameters(path) == {"mocap.subject": text}
