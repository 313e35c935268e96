"""Namespaces and full names of nodes are what ROS takes and lists."""

from hypothesis import example, given
from hypothesis import strategies as st
from rclpy.exceptions import InvalidNamespaceException
from rclpy.validate_namespace import validate_namespace

from collplan_ros.node_kit.node_names import full_name, is_in, namespace_from

namespaces = st.lists(st.from_regex("[A-Za-z_][A-Za-z0-9_]{0,5}", fullmatch=True), max_size=3).map(
    lambda parts: "/" + "/".join(parts)
)


def taken_by_ros(namespace: str) -> bool:
    try:
        return bool(validate_namespace(namespace))
    except InvalidNamespaceException:
        return False


@given(st.text("aZ_09/-~ \u00e9", max_size=8))
@example("a__b")
def test_a_namespace_is_taken_where_ros_takes_it(text):
    given_with_slash = text if text.startswith("/") else f"/{text}"
    try:
        assert namespace_from(text) == given_with_slash
    except ValueError:
        assert not taken_by_ros(given_with_slash)
    else:
        assert taken_by_ros(given_with_slash)


@given(namespaces, namespaces)
def test_a_node_is_in_its_own_namespace_alone(one, other):
    assert is_in(one, full_name(one, "mocap_node"))
    assert is_in(other, full_name(one, "mocap_node")) == (one == other)
