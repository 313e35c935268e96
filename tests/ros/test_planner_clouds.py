"""What the planner sees and compares, as point clouds: there and back, and only for whoever looks."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import PointCloud2

from collplan_core.parameters import Settings
from collplan_ros.messages.cloud_reading import compared_from_message, seen_from_message
from collplan_ros.messages.planner_clouds import (
    FREE_SPACE,
    FRONTIERS,
    INFERRED,
    LAYERS,
    PREDICTED,
    REMEMBERED,
    inferred_lines,
    seen_layers,
    seen_to_message,
)
from collplan_ros.messages.reading import MessageError, seconds_from_stamp
from fake_robot import planned

QUICK = settings(derandomize=True, deadline=None, max_examples=30)

SETTINGS = Settings().with_values({"time_to_goal.proposals": 100})
FLOAT32 = 2e-7
COORDINATES = st.floats(-100.0, 100.0, width=32)
POINTS = arrays.arrays(float, st.tuples(st.integers(0, 20), st.just(2)), elements=COORDINATES)


def over_the_wire(message):
    return deserialize_message(serialize_message(message), PointCloud2)


@pytest.fixture(scope="module", params=["harness", "bounce"])
def cycle(request):
    return planned(SETTINGS.with_values({"planner.strategy": request.param}))


def test_what_is_seen_comes_back(cycle):
    local_map, _, remembered = cycle
    message = over_the_wire(seen_to_message(seen_layers(local_map, remembered, SETTINGS), 3.25, "map"))
    assert (message.header.frame_id, seconds_from_stamp(message.header.stamp)) == ("map", 3.25)
    layers = seen_from_message(message, "map")
    np.testing.assert_allclose(layers[FREE_SPACE], local_map.border_points, rtol=FLOAT32)
    np.testing.assert_allclose(layers[FRONTIERS].reshape(-1, 4), local_map.segments, rtol=FLOAT32)
    np.testing.assert_allclose(layers[PREDICTED][::2], local_map.predicted[:, :2], rtol=FLOAT32)
    pieces = np.zeros((0, 4)) if remembered is None else remembered.pieces
    np.testing.assert_allclose(layers[REMEMBERED].reshape(-1, 4), pieces, rtol=FLOAT32)
    inferred = np.zeros((0, 2)) if remembered is None else inferred_lines(remembered, SETTINGS)
    np.testing.assert_allclose(layers[INFERRED], inferred, rtol=FLOAT32, atol=1e-7)


@QUICK
@given(st.dictionaries(st.sampled_from(LAYERS), POINTS))
def test_any_lines_come_back(layers):
    back = seen_from_message(seen_to_message(layers, 1.0, "map"), "map")
    assert set(back) == set(LAYERS)
    for name in LAYERS:
        np.testing.assert_array_equal(back[name], layers.get(name, np.zeros((0, 2))))


CHANGES = (
    lambda m: setattr(m.header, "frame_id", "odom"),
    lambda m: setattr(m, "width", 2**32 - 1),
    lambda m: setattr(m, "point_step", 4),
    lambda m: setattr(m, "is_bigendian", True),
    lambda m: setattr(m, "fields", m.fields[:2]),
    lambda m: setattr(m.fields[0], "datatype", 9),
    lambda m: setattr(m.fields[0], "offset", 2**31),
    lambda m: setattr(m.fields[0], "name", "y"),
)


def test_a_cloud_that_is_another_is_refused():
    for number, (change, read) in enumerate(itertools.product(CHANGES, (seen_from_message, compared_from_message))):
        message = seen_to_message({FREE_SPACE: np.eye(2)}, 0.0, "map")
        change(message)
        with pytest.raises(MessageError):
            pytest.fail(f"case {number}: {read(message, 'map')}")
