"""Parameters of nodes: declared from the groups, checked, live or not."""

import pytest
from rcl_interfaces.srv import DescribeParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter

from collplan_core.parameters import GROUPS, Lidar, Limits, LocalMapping, Mocap, Robot, Settings
from collplan_core.parameters.file import write_values
from collplan_core.parameters.spec import ParameterError, specs
from collplan_ros.node_kit.node_parameters import declare, on_change, read_settings


class Declaring(Node):
    def __init__(self, groups=(Robot, Mocap), **kwargs):
        super().__init__("declaring", **kwargs)
        declare(self, *groups)


def test_all_groups_at_their_defaults(ros):
    node = ros.make(lambda **kwargs: Declaring(GROUPS, **kwargs))
    assert read_settings(node, *GROUPS) == Settings()


def test_every_parameter_says_what_it_is(ros):
    node = ros.make(lambda **kwargs: Declaring(GROUPS, **kwargs))
    for spec in (spec for group in GROUPS for spec in specs(group)):
        descriptor = node.describe_parameter(spec.key)
        assert spec.doc in descriptor.description
        assert spec.unit in descriptor.description
        assert descriptor.read_only == (not spec.live)
        bounds = [*descriptor.integer_range, *descriptor.floating_point_range]
        assert [(b.from_value, b.to_value) for b in bounds] == ([] if spec.low is None else [(spec.low, spec.high)])


def test_description_over_the_graph(ros):
    ros.make(Declaring)
    request = DescribeParameters.Request(names=["robot.max_speed"])
    (descriptor,) = ros.call(DescribeParameters, "/declaring/describe_parameters", request).descriptors
    assert "m/s" in descriptor.description
    assert descriptor.floating_point_range[0].to_value == 5.0


def test_overrides_are_read(ros):
    node = ros.make(Declaring, {"robot.radius": 0.2, "mocap.detect_impacts": False, "robot.max_speed": 1})
    settings = read_settings(node, Robot, Mocap)
    assert (settings.robot.radius, settings.mocap.detect_impacts, settings.robot.max_speed) == (0.2, False, 1.0)


def test_parameters_of_other_nodes_are_ignored(ros):
    node = ros.make(Declaring, {"planner.map_period": 0.3, "use_sim_time": False, "robot.radius": 0.2})
    assert not node.has_parameter("planner.map_period")
    assert read_settings(node, Robot, Mocap) == Settings().with_values({"robot.radius": 0.2})


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("robot.max_sped", 1.0, "robot.max_speed"),
        ("max_speed", 1.0, "unknown parameter"),
        ("robot.max_speed", "fast", "expected a number"),
        ("robot.max_speed", 99.0, r"99\.0.*\[0\.05, 5\]"),
        ("robot.max_speed", float("nan"), "nan"),
        ("robot.radius", [0.1, 0.2], "expected a number"),
        ("mocap.detect_impacts", 1, "true or false"),
    ],
)
def test_override_that_does_not_fit_is_an_error(ros, key, value, words):
    with pytest.raises(ParameterError, match=words) as error:
        ros.make(Declaring, {key: value})
    assert key in str(error.value)


def set_on(ros, key, value):
    """The answer to `ros2 param set`."""
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


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("robot.max_speed", 99.0, "Min: 0.05, Max: 5.0, value: 99.0"),
        ("robot.max_speed", float("nan"), "value: nan"),
        ("robot.max_speed", "fast", "type"),
        ("robot.radius", 0.2, "read-only"),
    ],
)
def test_rejected_set_says_why_and_changes_nothing(ros, key, value, words):
    node = ros.make(Declaring)
    seen = []
    on_change(node, seen.append, Robot)
    answer = set_on(ros, key, value)
    assert not answer.successful
    assert words in answer.reason
    assert read_settings(node, Robot, Mocap) == Settings()
    assert not seen


def test_choice_that_does_not_exist_is_rejected(ros):
    groups = [group for group in GROUPS if group.group == "planner"]
    ros.make(lambda **kwargs: Declaring(groups, **kwargs))
    answer = set_on(ros, "planner.strategy", "bold")
    assert not answer.successful
    assert "harness, high_risk, low_risk" in answer.reason


def test_groups_that_check_more_than_one_value(ros):
    with pytest.raises(ParameterError, match="multiple of 4"):
        ros.make(lambda **kwargs: Declaring((LocalMapping, Lidar), **kwargs), {"local_map.n_rays": 361})


def test_one_parameter_of_another_nodes_group(ros):
    groups = (Robot, "mocap.leap_margin")
    node = ros.make(lambda **kwargs: Declaring(groups, **kwargs), {"mocap.leap_margin": 0.2})
    assert read_settings(node, *groups).mocap.leap_margin == 0.2
    assert not node.has_parameter("mocap.topic")
    assert set_on(ros, "mocap.leap_margin", 0.3).successful
    assert not set_on(ros, "mocap.leap_margin", 99.0).successful


@pytest.mark.parametrize("fence", [(), (0.0, 0.0, 2.0, 0.0, 2.0, 1.5)])
def test_a_list_of_a_parameter_file_is_read_an_empty_one_too(ros, tmp_path, fence):
    path = tmp_path / "lab.yaml"
    write_values({"limits.fence": list(fence)}, path)
    node = ros.make(
        lambda **kwargs: Declaring((Limits,), cli_args=["--ros-args", "--params-file", str(path)], **kwargs)
    )
    assert read_settings(node, Limits).limits.fence == fence
