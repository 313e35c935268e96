"""World files: written and read back, and every way in which one can be wrong."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.worlds import World, WorldError, load_world, save_world

coordinate = st.floats(-50, 50, allow_subnormal=False)


@st.composite
def worlds(draw) -> World:
    polygons = []
    for _ in range(draw(st.integers(0, 3))):
        x, y, size, turn = draw(coordinate), draw(coordinate), draw(st.floats(0.01, 3)), draw(st.floats(0, 6))
        angles = turn + 2 * np.pi * np.arange(n := draw(st.integers(3, 6))) / n
        polygons.append(np.stack([x + size * np.cos(angles), y + size * np.sin(angles)], axis=1))
    circles = draw(st.lists(st.tuples(coordinate, coordinate, st.floats(1e-6, 3)), max_size=3))
    # beyond every obstacle, so that start and goal are free wherever they are drawn
    corner = st.tuples(st.floats(60, 70), st.floats(60, 70))
    name = draw(st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs")), min_size=1, max_size=8))
    start, goal = draw(st.none() | corner), draw(st.none() | corner)
    return World(name, tuple(polygons), circles, (-60.0, -60.0, 80.0, 80.0), draw(st.booleans()), start, goal)


@settings(derandomize=True, deadline=None, max_examples=25)
@given(world=worlds())
def test_a_world_written_and_read_back_is_the_same_to_the_last_bit(world, tmp_path_factory):
    path = tmp_path_factory.mktemp("worlds") / "world.yaml"
    save_world(world, path)
    back = load_world(str(path))
    assert (back.name, back.bounds, back.walled) == (world.name, world.bounds, world.walled)
    shapes = [[*each.polygons, each.circles, each.start, each.goal] for each in (back, world)]
    for mine, theirs in zip(*shapes, strict=True):
        np.testing.assert_array_equal(mine, theirs)


def test_a_file_with_bounds_alone_is_an_empty_walled_arena_named_after_the_file(tmp_path):
    path = tmp_path / "hall.yml"
    path.write_text("bounds: [0, 0, 3, 2]\n")
    world = load_world(str(path))
    assert (world.name, world.bounds, world.walled) == ("hall", (0.0, 0.0, 3.0, 2.0), True)
    assert (world.polygons, world.start, world.goal) == ((), None, None)
    assert world.circles.shape == (0, 3)


EMPTY = "bounds: [0, 0, 1, 1]\n"
BAD = [
    ("bounds: [0, 0", "not YAML"),
    ("bounds: " + "[" * 3000, ".*too deep"),
    ("bounds: !!python/object:os.system {}", "not YAML"),
    ("start: 2001-02-30", "not YAML"),
    ("", "got None, .*name, bounds"),
    ("- 1\n- 2\n", r"got \[1, 2\]"),
    ("start: [1, 1]", "bounds: missing, .*x_min"),
    (EMPTY + "wals: true", "wals: unknown.* walled"),
    (EMPTY + "7: true", "7: unknown"),
    ("bounds: [0, 0, 1]", "bounds: got .*x_min"),
    ("bounds: [0, 0, 1, true]", "bounds: got"),
    ("bounds: [0, 0, 1, one]", "bounds: got"),
    (EMPTY + "walled: perhaps", "walled: got 'perhaps', .*true"),
    (EMPTY + "name: 7", "name: got 7"),
    (EMPTY + "polygons: {}", "polygons: got .*list"),
    (EMPTY + "polygons: [7]", r"polygons\[0\]: got 7, .*corners"),
    (EMPTY + "polygons: [[[0, 0], [1, 0], [0, x]]]", r"polygons\[0\]\[2\]: got .*\[x, y\]"),
    (EMPTY + "polygons: [[[0, 0], [1, 0], [0.2, 0.2], [0, 1]]]", r"polygons\[0\]: not convex"),
    (EMPTY + "circles: [[0, 0, 1]]", r"circles\[0\]: got .*{center"),
    (EMPTY + "circles: [{center: [0, 0]}]", r"circles\[0\]: got .*{center"),
    (EMPTY + "circles: [{center: [0], radius: 1}]", r"circles\[0\].center: got"),
    (EMPTY + "circles: [{center: [0, 0], radius: big}]", r"circles\[0\].radius: got 'big'"),
    (EMPTY + "start: [0.5]", r"start: got .*\[x, y\]"),
    (EMPTY + "start: [2, 0.5]", "start: .*outside"),
]


def test_a_wrong_file_is_named_with_its_key_and_the_expected_form(tmp_path):
    path = tmp_path / "broken.yaml"
    for text, words in BAD:
        path.write_text(text)
        with pytest.raises(WorldError, match=r"broken\.yaml: " + words):
            load_world(str(path))


def test_what_is_no_readable_text_file_is_refused(tmp_path):
    with pytest.raises(WorldError, match=r"missing\.yaml: no"):
        load_world(str(tmp_path / "missing.yaml"))
    (tmp_path / "folder.yaml").mkdir()
    with pytest.raises(WorldError, match=r"folder\.yaml: cannot"):
        load_world(str(tmp_path / "folder.yaml"))
    (tmp_path / "picture.yaml").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(WorldError, match=r"picture\.yaml: .*text"):
        load_world(str(tmp_path / "picture.yaml"))


def test_a_huge_world_is_refused(tmp_path):
    """By its size before it is read, which takes a second for 100 kB, else by its obstacles."""
    path = tmp_path / "huge.yaml"
    with path.open("wb") as file:
        file.truncate(2_000_000)
    with pytest.raises(WorldError, match=r"huge\.yaml: got 2000000 .*1048576"):
        load_world(str(path))
    with pytest.raises(WorldError, match=r"10001, .*10000"):
        World("huge", (), np.ones((10001, 3)), (0.0, 0.0, 2.0, 2.0))


def test_a_world_that_cannot_be_written_says_where(tmp_path):
    world = load_world("corridor")
    with pytest.raises(WorldError, match=r"no_such_folder.*written"):
        save_world(world, tmp_path / "no_such_folder" / "world.yaml")
