from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.worlds import World, WorldError
from collplan_study.barn.sdf import load_sdf
from sdf_files import BOX, CYLINDER, GOAL, GROUND, SPHERE, START, model, state, write

coordinates = st.floats(-3.0, 3.0, allow_nan=False).map(lambda value: round(value, 6))
angles = st.floats(-pi, pi, allow_nan=False).map(lambda value: round(value, 6))


def load(path: Path, scale: float = 1.0) -> World:
    return load_sdf(path, START, GOAL, scale)


def refusal(path: Path) -> str:
    with pytest.raises(WorldError) as caught:
        load(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    return message


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("name", ["small.world", "small.world.gz", "small.sdf"])
def test_compression_is_told_by_the_content(tmp_path, compressed, name):
    world = load(write(tmp_path, model(CYLINDER, at="1 2 0.5 0 0 0"), name=name, compressed=compressed))
    np.testing.assert_array_equal(world.circles, [[1.0, 2.0, 0.2]])
    assert world.name == "small"


def test_what_collides_counts_once_and_the_ground_not_at_all(tmp_path):
    things = [model(CYLINDER, "a"), model(SPHERE, "b", "1 0 0.3 0.5 0.5 0.5"), model(BOX, "c", "0 2 0 0 0 0")]
    seen = "<model name='d'><link name='l'><visual name='v'><geometry><mesh/></geometry></visual></link></model>"
    world = load(write(tmp_path, GROUND, *things, seen, "<include><uri>model://sun</uri></include>"))
    np.testing.assert_allclose(world.circles, [[0.0, 0.0, 0.2], [1.0, 0.0, 0.3]])
    assert len(world.polygons) == 1


def test_bounds_are_no_walls_and_a_metre_around_obstacles_start_and_goal(tmp_path):
    world = load(write(tmp_path, model(CYLINDER, "a", "1 4 0 0 0 0"), model(BOX, "b", "0 -3 0 0 0 0")))
    np.testing.assert_allclose(world.bounds, [-6.0, -4.5, 6.0, 5.2])
    assert not world.walled
    np.testing.assert_array_equal([world.start, world.goal], [START, GOAL])


def test_box_turned_by_its_yaw(tmp_path):
    (corners,) = load(write(tmp_path, model(BOX, at=f"1 2 0 0 0 {pi / 2}"))).polygons
    np.testing.assert_allclose(corners.min(axis=0), [0.5, 1.0])
    np.testing.assert_allclose(corners.max(axis=0), [1.5, 3.0])


def test_poses_of_the_state_win(tmp_path):
    thing = model(CYLINDER, at="3 3 0 0 0 0", link_at="1 0 0 0 0 0")
    world = load(write(tmp_path, thing, state(at=f"0 1 0 0 0 {pi / 2}")))
    np.testing.assert_allclose(world.circles, [[0.0, 2.0, 0.2]], atol=1e-12)


def test_links_of_the_state_are_placed_in_the_world(tmp_path):
    thing = model(CYLINDER, at="3 3 0 0 0 0", link_at="1 0 0 0 0 0", collision_at="0 0.5 0 0 0 0")
    world = load(write(tmp_path, thing, state(at="0 1 0 0 0 0", link_at="-1 1 0 0 0 0")))
    np.testing.assert_allclose(world.circles, [[-1.0, 1.5, 0.2]])


def test_a_state_of_something_else_moves_nothing(tmp_path):
    world = load(write(tmp_path, model(CYLINDER, at="1 0 0 0 0 0"), state("other", at="9 9 0 0 0 0")))
    np.testing.assert_array_equal(world.circles[:, :2], [[1.0, 0.0]])


def turned(x: float, y: float, yaw: float) -> np.ndarray:
    return np.array([[np.cos(yaw), -np.sin(yaw), x], [np.sin(yaw), np.cos(yaw), y], [0.0, 0.0, 1.0]])


@settings(derandomize=True, deadline=None, max_examples=25)
@given(poses=st.lists(st.tuples(coordinates, coordinates, angles), min_size=3, max_size=3))
def test_poses_compose_from_model_over_link_to_collision(tmp_path_factory, poses):
    texts = [f"{x} {y} 0 0 0 {yaw}" for x, y, yaw in poses]
    path = write(tmp_path_factory.mktemp("sdf"), model(BOX, "a", *texts))
    expected = turned(*poses[0]) @ turned(*poses[1]) @ turned(*poses[2])
    corners = expected @ np.array([[-1, 1, 1, -1], [-0.5, -0.5, 0.5, 0.5], [1, 1, 1, 1]])
    far = np.array([30.0, 30.0])
    (got,) = load_sdf(path, far, -far).polygons
    np.testing.assert_allclose(got, corners[:2].T, atol=1e-9)


@settings(derandomize=True, deadline=None, max_examples=15)
@given(scale=st.floats(0.05, 4.0))
def test_scale_is_one_factor_on_every_length(tmp_path_factory, scale):
    path = write(tmp_path_factory.mktemp("sdf"), model(CYLINDER, "a", "1 2 0 0 0 0"), model(BOX, "b", "0 -2 0 0 0 1"))
    world, scaled = load(path), load(path, scale)
    np.testing.assert_allclose(scaled.circles, scale * world.circles)
    np.testing.assert_allclose(scaled.polygons[0], scale * world.polygons[0])
    np.testing.assert_allclose([scaled.start, scaled.goal], [scale * START, scale * GOAL])


@pytest.mark.parametrize("scale", [0.0, -1.0, float("nan"), float("inf")])
def test_scale_that_is_none(tmp_path, scale):
    with pytest.raises(WorldError, match="scale: got"):
        load(write(tmp_path, model(CYLINDER)), scale)


@pytest.mark.parametrize("shape", ["mesh", "heightmap", "polyline", "capsule", "ellipsoid", "image"])
def test_unsupported_shape_is_named_with_its_model_and_line(tmp_path, shape):
    path = write(tmp_path, model(CYLINDER, "fine"), model(f"<{shape}><uri>x</uri></{shape}>", "odd"))
    line = 1 + [shape in text for text in path.read_text().splitlines()].index(True)
    assert f"{path}:{line}: model 'odd': {shape}: not supported" in refusal(path)


@pytest.mark.parametrize(
    "piece",
    [
        "<include><uri>model://house</uri></include>",
        "<population name='p'><model name='m'/></population>",
        f"<model name='outer'>{model(CYLINDER)}</model>",
        "<state world_name='w'><insertions/></state>",
        "<state world_name='w'><deletions/></state>",
    ],
)
def test_what_brings_in_or_takes_away_obstacles_is_refused(tmp_path, piece):
    assert "not supported" in refusal(write(tmp_path, model(CYLINDER), piece))


@pytest.mark.parametrize(
    ("piece", "expected"),
    [
        (model("<cylinder><length>1</length></cylinder>"), ":6: model 'thing': cylinder: radius is missing"),
        (model("<cylinder><radius>-1</radius></cylinder>"), "cylinder: got radius '-1', expected more than 0"),
        (model("<sphere><radius>nan</radius></sphere>"), "radius: got 'nan', expected 1 finite numbers"),
        (model("<sphere><radius/></sphere>"), "radius: got '', expected 1 finite numbers"),
        (model("<box><size>1 2</size></box>"), "size: got '1 2', expected 3 finite numbers"),
        (model(CYLINDER, at="0 0 zero 0 0 0"), ":3: pose: got '0 0 zero 0 0 0', expected 6 finite numbers"),
        (model(CYLINDER, at="0 0 0 1.57 0 0"), "cylinder: lies tilted"),
        (model(BOX, link_at="0 0 0 0 0.1 0"), "box: lies tilted"),
        (model(CYLINDER + BOX), "collision with 2 shapes, expected one"),
        (model(""), "collision with 0 shapes, expected one"),
        (model(CYLINDER).replace("frame=''", "") + state(scale="2 1 1"), "got scale '2 1 1', expected 1 1 1"),
        (model(CYLINDER, at="0 0 0 0 0 0").replace("frame=''", "relative_to='door'"), "'relative_to': 'door'"),
        (model(CYLINDER, at="-5 0 0 0 0 0"), "start: [-5.0, 0.0] is inside circles[0]"),
        (GROUND, "holds no obstacles"),
        ("", "holds no obstacles"),
        ("</world><world name='second'>", "got 2 worlds, expected <sdf> with one <world>"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(tmp_path, piece, expected):
    assert expected in refusal(write(tmp_path, piece))
