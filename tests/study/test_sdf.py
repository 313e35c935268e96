"""Worlds in SDF as world files: what is an obstacle, what is left out and said, and what is refused with its place."""

import numpy as np
import pytest

from collplan_core.worlds import WorldError
from sdf import load_sdf
from sdf_files import CYLINDER, model, write

BOX = "<box><size>2 1 0.5</size></box>"
START, GOAL = (-5.0, 0.0), (5.0, 0.0)


def turned(x, y, yaw):
    return np.array([[np.cos(yaw), -np.sin(yaw), x], [np.sin(yaw), np.cos(yaw), y], [0.0, 0.0, 1.0]])


def test_poses_compose_those_of_the_state_win_and_scale_is_one_factor(tmp_path):
    poses = [(1.0, 2.0, 0.3), (0.5, -1.0, -1.2), (0.2, 0.1, 2.0)]
    texts = [f"{x} {y} 0 0 0 {yaw}" for x, y, yaw in poses]
    moved = "<state><model name='b'><pose>0 3 0 0 0 0</pose></model></state>"
    path = write(tmp_path, model(BOX, "a", *texts), model(CYLINDER, "b", "1 2 0 0 0 0"), moved, name="small.world.gz")
    world = load_sdf(path, START, GOAL, 0.5)
    corners = np.linalg.multi_dot([*map(turned, *zip(*poses, strict=True))])
    corners = corners @ np.array([[-1, 1, 1, -1], [-0.5, -0.5, 0.5, 0.5], [1, 1, 1, 1]])
    np.testing.assert_allclose(world.polygons[0], 0.5 * corners[:2].T)
    np.testing.assert_allclose(world.circles, [[0.0, 1.5, 0.1]])
    assert (world.name, world.walled, world.start.tolist()) == ("small", False, [-2.5, 0.0])


WRONG = [
    (model("<mesh><uri>x</uri></mesh>"), ":6: model 'thing': mesh"),
    ("<include><uri>model://house</uri></include>", "model://house"),
    ("<include><uri>https://fuel.gazebosim.org/1.0/a/models/Sunny House/2</uri></include>", "Sunny House"),
    ("<actor name='walker'><link name='l'/></actor>", "actor: not supported"),
    (
        model(CYLINDER).replace("name='thing'", "name='thing' placement_frame='tip'"),
        "model 'thing': model: placement",
    ),
    (model(CYLINDER).replace("<link ", "<model name='inner'/><link "), "model 'inner'"),
    (model("<plane><normal>1 0 0</normal></plane>"), "is no ground"),
    (model(CYLINDER, at="0 0 3 0 0 0"), "no obstacles up to 0.5 m"),
    (model(CYLINDER, at="0 0 0 1.57 0 0"), "tilted"),
    (model(CYLINDER, at="-5 0 0 0 0 0"), "start: [-5.0, 0.0] is inside model 'thing'"),
    ("</world><world name='second'>", "2 worlds"),
]


def test_what_cannot_be_used_is_named_with_its_file(tmp_path):
    for piece, expected in WRONG:
        with pytest.raises(WorldError) as caught:
            load_sdf(write(tmp_path, piece), START, GOAL)
        assert expected in str(caught.value)
        assert "small.world" in str(caught.value)
    entity = "<!DOCTYPE sdf [<!ENTITY x SYSTEM 'file:///etc/hostname'>]>"
    with pytest.raises(WorldError, match="document type"):
        load_sdf(write(tmp_path, model(CYLINDER), head=entity), START, GOAL)


GROUNDS = (
    "<include><uri>https://fuel.gazebosim.org/1.0/OpenRobotics/models/Ground Plane</uri></include>",
    "<include><uri>https://fuel.gazebosim.org/1.0/OpenRobotics/models/Sun/3</uri></include>",
    "<include><uri>model://ground_plane/</uri></include>",
    model("<plane><normal>0 0 1</normal><size>9 9</size></plane>", "plane"),
    model("<box><size>20 20 0.1</size></box>", "slab", at="0 0 -0.05 0 0 0"),
    "<light name='sun'/><physics/><frame name='tip'/>",
)


@pytest.mark.parametrize("ground", GROUNDS)
def test_ground_is_no_obstacle(tmp_path, ground):
    world = load_sdf(write(tmp_path, ground, model(CYLINDER)), START, GOAL)
    assert (len(world.polygons), world.circles.tolist()) == (0, [[0.0, 0.0, 0.2]])


def test_what_hangs_above_the_robot_and_what_could_move_is_left_out_and_said(tmp_path):
    lintel = model(BOX, "lintel", at="0 0 2.1 0 0 0")
    door = model(BOX, "door").replace("</model>", "<joint name='hinge' type='revolute'/></model>")
    path, said = write(tmp_path, lintel, door, "<plugin filename='mover.so' name='m'/>"), []
    low, high = (load_sdf(path, START, GOAL, height=height, say=said.append) for height in (0.5, 2.0))
    assert (len(low.polygons), len(high.polygons)) == (1, 2)
    assert [word in text for word, text in zip(("1 of 2", "hinge", "mover.so"), said, strict=False)] == [True] * 3
