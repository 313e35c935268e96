"""Worlds in SDF files: what becomes of shapes and poses, and what is refused in one line with its file."""

import gzip
import os
import tracemalloc
from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.worlds import World, WorldError
from collplan_study.barn import xml_file
from collplan_study.barn.sdf import load_sdf
from sdf_files import BOX, CYLINDER, GOAL, GROUND, SPHERE, START, model, state, write, write_text

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


def test_compression_is_known_by_the_content(tmp_path):
    for compressed in (False, True):
        for name in ("small.world", "small.world.gz", "small.sdf"):
            world = load(write(tmp_path, model(CYLINDER, at="1 2 0.5 0 0 0"), name=name, compressed=compressed))
            np.testing.assert_array_equal(world.circles, [[1.0, 2.0, 0.2]])
            assert world.name == "small"


def test_what_collides_counts_once_and_the_ground_not_at_all(tmp_path):
    things = [model(CYLINDER, "a"), model(SPHERE, "b", "1 0 0.3 0.5 0.5 0.5"), model(BOX, "c", "0 2 0 0 0 0")]
    seen = "<model name='d'><link name='l'><visual name='v'><geometry><mesh/></geometry></visual></link></model>"
    world = load(write(tmp_path, GROUND, *things, seen, "<include><uri>model://sun</uri></include>"))
    np.testing.assert_allclose(world.circles, [[0.0, 0.0, 0.2], [1.0, 0.0, 0.3]])
    assert len(world.polygons) == 1

    # bounds are no walls and a metre around obstacles, start and goal
    world = load(write(tmp_path, model(CYLINDER, "a", "1 4 0 0 0 0"), model(BOX, "b", "0 -3 0 0 0 0")))
    np.testing.assert_allclose(world.bounds, [-6.0, -4.5, 6.0, 5.2])
    assert not world.walled
    np.testing.assert_array_equal([world.start, world.goal], [START, GOAL])


def test_poses_of_the_state_win_and_those_of_its_links_are_in_the_world(tmp_path):
    thing = model(CYLINDER, at="3 3 0 0 0 0", link_at="1 0 0 0 0 0")
    turned_state = state(at=f"0 1 0 0 0 {pi / 2}")
    np.testing.assert_allclose(load(write(tmp_path, thing, turned_state)).circles, [[0.0, 2.0, 0.2]], atol=1e-12)
    thing = model(CYLINDER, at="3 3 0 0 0 0", link_at="1 0 0 0 0 0", collision_at="0 0.5 0 0 0 0")
    of_link = state(at="0 1 0 0 0 0", link_at="-1 1 0 0 0 0")
    np.testing.assert_allclose(load(write(tmp_path, thing, of_link)).circles, [[-1.0, 1.5, 0.2]])
    of_another = state("other", at="9 9 0 0 0 0")
    moved = load(write(tmp_path, model(CYLINDER, at="1 0 0 0 0 0"), of_another))
    np.testing.assert_array_equal(moved.circles[:, :2], [[1.0, 0.0]])


def turned(x: float, y: float, yaw: float) -> np.ndarray:
    return np.array([[np.cos(yaw), -np.sin(yaw), x], [np.sin(yaw), np.cos(yaw), y], [0.0, 0.0, 1.0]])


@given(st.lists(st.tuples(coordinates, coordinates, angles), min_size=3, max_size=3), st.floats(0.05, 4.0))
def test_poses_compose_from_model_over_link_to_collision_and_scale_is_one_factor(tmp_path_factory, poses, scale):
    texts = [f"{x} {y} 0 0 0 {yaw}" for x, y, yaw in poses]
    path = write(tmp_path_factory.mktemp("sdf"), model(BOX, "a", *texts), model(CYLINDER, "b", "1 2 0 0 0 0"))
    expected = turned(*poses[0]) @ turned(*poses[1]) @ turned(*poses[2])
    corners = expected @ np.array([[-1, 1, 1, -1], [-0.5, -0.5, 0.5, 0.5], [1, 1, 1, 1]])
    far = np.array([30.0, 30.0])
    scaled = load_sdf(path, far, -far, scale)
    np.testing.assert_allclose(scaled.polygons[0], scale * corners[:2].T, atol=1e-8)
    np.testing.assert_allclose(scaled.circles, [[scale, 2.0 * scale, 0.2 * scale]])
    np.testing.assert_allclose([scaled.start, scaled.goal], [scale * far, -scale * far])


def test_shapes_that_are_not_supported_are_named_with_their_model_and_line(tmp_path):
    for shape in ("mesh", "heightmap", "polyline", "capsule", "ellipsoid", "image"):
        path = write(tmp_path, model(CYLINDER, "fine"), model(f"<{shape}><uri>x</uri></{shape}>", "odd"))
        line = 1 + [shape in text for text in path.read_text().splitlines()].index(True)
        assert f"{path}:{line}: model 'odd': {shape}" in refusal(path)


WRONG = [
    ("<include><uri>model://house</uri></include>", "not supported"),
    (f"<model name='outer'>{model(CYLINDER)}</model>", "not supported"),
    ("<state world_name='w'><insertions/></state>", "not supported"),
    (model("<cylinder><length>1</length></cylinder>"), ":6: model 'thing': cylinder"),
    (model("<cylinder><radius>-1</radius></cylinder>"), "radius '-1'"),
    (model("<sphere><radius>nan</radius></sphere>"), "got 'nan'"),
    (model("<box><size>1 2</size></box>"), "size: got"),
    (model(CYLINDER, at="0 0 zero 0 0 0"), ":3: pose"),
    (model(CYLINDER, at="0 0 0 1.57 0 0"), "tilted"),
    (model(CYLINDER + BOX), "2 shapes"),
    (model(CYLINDER).replace("frame=''", "") + state(scale="2 1 1"), "got scale"),
    (model(CYLINDER, at="0 0 0 0 0 0").replace("frame=''", "relative_to='door'"), "'door'"),
    (model(CYLINDER, at="-5 0 0 0 0 0"), "inside circles[0]"),
    (GROUND, "no obstacles"),
    ("</world><world name='second'>", "2 worlds"),
]


def test_what_is_wrong_is_said_in_one_line(tmp_path):
    for scale in (0.0, float("nan"), float("inf")):
        with pytest.raises(WorldError, match="scale"):
            load(write(tmp_path, model(CYLINDER)), scale)
    for piece, expected in WRONG:
        pieces = (model(CYLINDER), piece) if expected == "not supported" else (piece,)
        assert expected in refusal(write(tmp_path, *pieces)), piece


LAUGHS = "<!ENTITY a0 'ha'>" + "".join(f"<!ENTITY a{n + 1} '{f'&a{n};' * 10}'>" for n in range(9))
DECLARATIONS = [
    f"<!DOCTYPE sdf [{LAUGHS}]>",
    "<!DOCTYPE sdf [<!ENTITY x SYSTEM 'file:///etc/hostname'>]>",
    "<!DOCTYPE sdf [<!ENTITY % x SYSTEM 'http://127.0.0.1:9/x'> %x;]>",
]


def test_declarations_are_refused(tmp_path):
    for k, declaration in enumerate(DECLARATIONS):
        body = f"<sdf><world name='&a9;&x;'>{model(CYLINDER)}</world></sdf>"
        path = write_text(tmp_path, f"<?xml version='1.0'?>\n{declaration}\n{body}", compressed=bool(k % 2))
        assert f"{path}:2: a document" in refusal(path)


def test_what_is_too_large_is_never_read(tmp_path, monkeypatch):
    bomb, huge = tmp_path / "bomb.world.gz", tmp_path / "huge.world"
    with gzip.open(bomb, "wb", compresslevel=9) as file:
        file.write(b"<sdf>" + b" " * (4 * xml_file.LARGEST))
    with huge.open("wb") as file:
        file.truncate(2**40)
    tracemalloc.start()
    try:
        for path in (bomb, huge):
            assert "larger than" in refusal(path)
        assert tracemalloc.get_traced_memory()[1] < 4 * xml_file.LARGEST
    finally:
        tracemalloc.stop()
    assert "nested deeper" in refusal(write(tmp_path, "<model name='m'>" * 200, "</model>" * 200))
    monkeypatch.setattr(xml_file, "MOST_ELEMENTS", 50)
    assert "than 50" in refusal(write(tmp_path, "\n<light/>" * 60))


ZIPPED = gzip.compress(b"<sdf></sdf>", mtime=0)
NO_WORLDS = [
    (b"", "not XML"),
    (ZIPPED[:-9], "cannot be read"),
    (ZIPPED[:12] + b"\xff" * 20, "cannot be read"),
    (b"<sdf>\n<world>\n</sdf>", ":3: not XML"),
    (b"<sdf>\xff\xfe</sdf>", "not XML"),
    (b"<?xml version='1.0' encoding='nonsense'?><sdf/>", "not XML"),
    (b"<html/>", ":1: got <html>"),
    (b"<sdf/>", "0 worlds"),
]


def test_what_is_no_world_or_no_file(tmp_path):
    path = tmp_path / "some.world"
    for content, expected in NO_WORLDS:
        path.write_bytes(content)
        assert expected in refusal(path), content
    assert "no such" in refusal(tmp_path / "none.world")
    os.mkfifo(tmp_path / "pipe.world")
    for path in (tmp_path, tmp_path / "pipe.world"):
        assert "a file" in refusal(path)
