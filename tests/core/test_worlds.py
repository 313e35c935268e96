"""What a world is, its files, the shipped arenas, how a world is named, and what each seeded family promises."""

import hashlib
from dataclasses import replace
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from collplan_core.worlds import Mover, World, WorldError, check_route, load_world, save_world, world_segments
from collplan_core.worlds.families import FAMILIES
from collplan_core.worlds.route import free_space
from collplan_core.worlds.shapes import obstacle_at

BOUNDS = (0.0, 0.0, 2.0, 1.0)
SQUARE = [[0.5, 0.2], [0.9, 0.2], [0.9, 0.6], [0.5, 0.6]]


def world_of(polygons=(), circles=(), bounds=BOUNDS, walled=True, start=None, goal=None) -> World:
    return World("w", polygons, circles, bounds, walled, start, goal)


def regular_polygon(n_corners: int, turn: float, x: float, y: float, size: float) -> np.ndarray:
    angles = turn + 2 * np.pi * np.arange(n_corners) / n_corners
    return np.array([x, y]) + size * np.stack([np.cos(angles), np.sin(angles)], axis=1)


@given(
    n_corners=st.integers(3, 9), turn=st.floats(0, 6), size=st.floats(0.01, 5),
    roll=st.integers(0, 8), backwards=st.booleans(),
)  # fmt: skip
def test_a_convex_polygon_comes_out_counter_clockwise_with_the_same_corners(n_corners, turn, size, roll, backwards):
    corners = np.roll(regular_polygon(n_corners, turn, 1.0, 2.0, size), roll, axis=0)
    given_corners = corners[::-1] if backwards else corners
    polygon = world_of([given_corners]).polygons[0]
    assert shapely.is_ccw(shapely.LinearRing(polygon))
    assert {tuple(p) for p in polygon} == {tuple(p) for p in corners}


def test_bad_values_are_refused_and_named():
    pentagram = regular_polygon(5, 0.0, 0.0, 0.0, 1.0)[[0, 2, 4, 1, 3]]
    polygons = (
        (pentagram, "crosses itself"),
        ([[0, 0], [1, 0]], "2 corners"),
        ([[0, 0], [1, 0], [1, 0], [0, 1]], "equal"),
        ([[0, 0], [1, float("nan")], [0, 1]], "got"),
    )
    fields = (
        ({"circles": [[0, 0, 1], [0, 0, 0.0]]}, r"circles\[1\].radius: .*0"),
        ({"bounds": (0, 0, 0, 1)}, "bounds: got.*x_min < x_max"),
        ({"start": (3, 0.5)}, "start: .*outside"),
        ({"goal": (0.5, np.nan)}, r"goal\[1\]: got"),
        ({"start": (0.7, 0.4), "polygons": [SQUARE]}, r"start: .*inside polygons\[0\]"),
        ({"goal": (1.5, 0.5), "circles": [[1.5, 0.4, 0.2]]}, r"goal: .*inside circles\[0\]"),
    )
    bad = [({"polygons": [SQUARE, polygon]}, rf"polygons\[1\](\[\d\])?: .*{words}") for polygon, words in polygons]
    for values, words in (*bad, *fields):
        with pytest.raises(WorldError, match=words):
            world_of(**values)


def test_segments_are_the_edges_and_the_walls():
    world = world_of([[[0.5, 0.2], [0.9, 0.2], [0.5, 0.6]]])
    expected = [
        [0.5, 0.2, 0.9, 0.2], [0.9, 0.2, 0.5, 0.6], [0.5, 0.6, 0.5, 0.2],
        [0, 0, 2, 0], [2, 0, 2, 1], [2, 1, 0, 1], [0, 1, 0, 0],
    ]  # fmt: skip
    np.testing.assert_array_equal(world_segments(world), expected)
    np.testing.assert_array_equal(world_segments(world_of(world.polygons, walled=False)), expected[:3])
    assert world_segments(world_of(walled=False)).shape == (0, 4)


# a wall across the arena but for a gap above it, 0.2 m wide
GATE = [[0.9, -0.1], [1.1, -0.1], [1.1, 0.8], [0.9, 0.8]]


def test_a_route_depends_on_the_radius_needs_room_at_its_ends_and_without_walls_may_leave_the_arena():
    start, goal = np.array([0.4, 0.5]), np.array([1.6, 0.5])
    closed = [[0.9, -0.1], [1.1, -0.1], [1.1, 1.1], [0.9, 1.1]]
    check_route(world_of([GATE]), start, goal, 0.099)
    check_route(world_of([closed], walled=False), start, goal, 0.1)
    for world, radius in ((world_of([GATE]), 0.101), (world_of([closed]), 0.1)):
        with pytest.raises(WorldError, match=r"goal: .*reached"):
            check_route(world, start, goal, radius)
    for start, goal, words in (
        ((0.4, 0.5), (1.0, 0.5), "goal: .*obstacle"),
        ((1.6, 0.5), (2.5, 0.5), "goal: .*outside"),
        ((np.nan, 0.5), (1.6, 0.5), "start: .*outside"),
    ):
        with pytest.raises(WorldError, match=words):
            check_route(world_of([GATE]), np.array(start), np.array(goal), 0.09)


def test_a_route_may_end_within_the_tolerance_of_its_goal():
    start, goal = np.array([0.4, 0.5]), np.array([0.86, 0.5])  # 4 cm before the gate
    check_route(world_of([GATE]), start, goal, 0.09, 0.06)
    for tolerance, words in ((0.04, "goal: .*within 0.04 m"), (0.0, "goal: .*0.09 m of room around it")):
        with pytest.raises(WorldError, match=words):
            check_route(world_of([GATE]), start, goal, 0.09, tolerance)
    behind = np.array([1.15, 0.95])
    with pytest.raises(WorldError, match=r"goal: .*reached"):
        check_route(world_of([[[0.9, -0.1], [1.1, -0.1], [1.1, 1.1], [0.9, 1.1]]]), start, behind, 0.09, 0.06)


def test_no_mover_begins_on_the_start_of_a_route():
    start, goal = np.array([0.4, 0.5]), np.array([1.6, 0.5])
    for x, said in ((0.4, "is 0.00 m from"), (0.58, "is 0.18 m from"), (0.61, "")):
        world = replace(world_of([GATE]), movers=(Mover(0.11, np.array([[x, 0.5], [0.2, 0.5]]), 1.0),))
        if not said:
            check_route(world, start, goal, 0.09)
            continue
        words = rf"movers\[0\]\.way\[0\]: \[{x}, 0\.5\] {said} the robot's start, expected at least 0\.2 m"
        with pytest.raises(WorldError, match=words):
            check_route(world, start, goal, 0.09)


SLOT = ([[0.0, 0.0], [1.0, 0.0], [1.0, 0.41], [0.0, 0.41]], [[0.0, 0.59], [1.0, 0.59], [1.0, 1.0], [0.0, 1.0]])
TOUCHING = [
    ((), (), (0.09, 0.5)),
    ((), (), (0.09, 0.09)),
    (SLOT, (), (0.3, 0.5)),
    ((), ((0.5, 0.5, 0.1),), (0.69, 0.5)),
    (([[0.5, 0.5], [0.9, 0.5], [0.9, 0.9], [0.5, 0.9]],), (), (0.5 - 0.09 * np.sqrt(0.5),) * 2),
]


@pytest.mark.parametrize("far", [(0.0, 0.0), (1e3, -2e3), (4e5, 5e6), (1e9, 1e9)])
@pytest.mark.parametrize(("polygons", "circles", "start"), TOUCHING)
def test_a_disc_that_touches_has_room_and_a_tenth_of_a_millimetre_deeper_has_none(polygons, circles, start, far):
    moved = tuple(np.array(corners) + far for corners in polygons)
    round_ones = np.array(circles).reshape(-1, 3) + np.array([*far, 0.0])
    world = World("w", moved, round_ones, (*far, far[0] + 2.0, far[1] + 1.0))
    start, goal = np.array(start) + far, np.array((1.7, 0.5)) + far
    check_route(world, start, goal, 0.09)
    with pytest.raises(WorldError, match=r"start: .*near"):
        check_route(world, start, goal, 0.0901)


def test_a_name_that_means_nothing_is_refused():
    for spec, words in (
        ("coridor", "unknown.*random:SEED.*corridor"),
        ("random", "seed '', .*whole"),
        ("random:²", "seed '²'"),
        ("nowhere/at/all.yaml", "nowhere/at/all.yaml: no"),
    ):
        with pytest.raises(WorldError, match=words):
            load_world(spec)


coordinate = st.floats(-50, 50, allow_subnormal=False)


@st.composite
def worlds(draw) -> World:
    polygons = []
    for _ in range(draw(st.integers(0, 3))):
        x, y, size, turn = draw(coordinate), draw(coordinate), draw(st.floats(0.01, 3)), draw(st.floats(0, 6))
        polygons.append(regular_polygon(draw(st.integers(3, 6)), turn, x, y, size))
    circles = draw(st.lists(st.tuples(coordinate, coordinate, st.floats(1e-6, 3)), max_size=3))
    # beyond every obstacle, so that start and goal are free wherever they are drawn
    corner = st.tuples(st.floats(60, 70), st.floats(60, 70))
    name = draw(st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs")), min_size=1, max_size=8))
    start, goal = draw(st.none() | corner), draw(st.none() | corner)
    return World(name, tuple(polygons), circles, (-60.0, -60.0, 80.0, 80.0), draw(st.booleans()), start, goal)


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
BOMB = "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 9))
BAD = [
    ("bounds: [0, 0", "not YAML"),
    ("bounds: " + "[" * 3000, ".*too deep"),
    ("start: [1, 1]", "bounds: missing, .*x_min"),
    (EMPTY + "wals: true", "wals: unknown.* walled"),
    ("bounds: [0, 0, 1, true]", "bounds: got"),
    (EMPTY + "walled: perhaps", "walled: got 'perhaps', .*true"),
    (EMPTY + "polygons: [7]", r"polygons\[0\]: got 7, .*corners"),
    (EMPTY + "polygons: [[[0, 0], [1, 0], [0.2, 0.2], [0, 1]]]", r"polygons\[0\]: not convex"),
    (EMPTY + "circles: [{center: [0, 0], radius: big}]", r"circles\[0\].radius: got 'big'"),
    # as strictly as a parameter file
    (EMPTY + "circles: [{center: [1, 1], radius: 1, radius: 2}]", ".*line 2: radius"),
    ("a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]\n" + BOMB + EMPTY, ".*by aliases"),
]


def test_a_wrong_file_is_named_with_its_key_and_the_expected_form(tmp_path):
    path = tmp_path / "broken.yaml"
    for text, words in BAD:
        path.write_text(text)
        with pytest.raises(WorldError, match=r"broken\.yaml: " + words):
            load_world(str(path))


MAP = (
    "image: map.pgm\nresolution: 0.05\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n"
)


def write_map(folder: Path, grey: np.ndarray, text: str = MAP, plain: bool = False) -> str:
    head = f"{'P2' if plain else 'P5'}\n# a map\n{grey.shape[1]} {grey.shape[0]}\n255\n".encode()
    rows = b"\n".join(b" ".join(b"%d" % value for value in row) for row in grey)
    (folder / "map.pgm").write_bytes(head + (rows if plain else grey.astype(np.uint8).tobytes()))
    (folder / "map.yaml").write_text(text)
    return str(folder / "map.yaml")


@given(
    height=st.integers(1, 7), shades=st.lists(st.sampled_from([0, 80, 100, 205, 254]), min_size=42, max_size=42),
    negate=st.booleans(), plain=st.booleans(),
)  # fmt: skip
def test_the_rectangles_of_a_map_hold_the_centres_of_all_occupied_cells_and_of_no_other(
    height, shades, negate, plain, tmp_path_factory
):
    grey = np.array(shades[: 42 // height * height]).reshape(height, -1)
    text = MAP.replace("negate: 0", f"negate: {int(negate)}") + "mode: trinary\n"
    world = load_world(write_map(tmp_path_factory.mktemp("map"), grey, text, plain))
    occupied = (grey if negate else 255 - grey)[::-1] > 0.65 * 255
    for (row, column), solid in np.ndenumerate(occupied):
        centre = np.array([-1.0, 2.0]) + 0.05 * np.array([column + 0.5, row + 0.5])
        assert bool(obstacle_at(world, centre)) == solid, (row, column)
    assert world.bounds == pytest.approx((-1.0, 2.0, -1.0 + 0.05 * grey.shape[1], 2.0 + 0.05 * height))
    assert not world.walled


def test_a_map_that_does_not_fit_is_refused_by_name(tmp_path):
    speckles = np.where(np.indices((90, 90)).sum(axis=0) % 2, 0, 254)
    for change, words in (
        (("0.0]", "0.1]"), "origin: got yaw 0.1, expected 0"),
        (("resolution: 0.05", "resolution: 0"), "resolution: got 0"),
        (("[-1.0", "[.nan"), "origin: got x nan"),
        (("negate: 0\n", "negate: 0\nnegate: 1\n"), "line 5: negate: given in line 4"),
        (("0.65", "65"), "occupied_thresh: got 65"),
        (("negate: 0", "negate: 0\nmode: raw"), "mode: got 'raw', expected trinary or scale"),
        (("map.pgm", "map.yaml"), "image: .*expected a PGM"),
        (("", ""), "image: got 4050 rectangles.*at most 4000"),
    ):
        with pytest.raises(WorldError, match=r"map\.yaml: " + words):
            load_world(write_map(tmp_path, speckles, MAP.replace(*change)))
    with pytest.raises(WorldError, match=r"start: .*an occupied cell \(negate"):
        load_world(write_map(tmp_path, speckles[:20, :20], MAP + "start: [-0.975, 2.025]\n"))
    assert load_world(write_map(tmp_path, speckles[:20, :20], MAP.replace("0.05", "5e-2").replace("0.0]", "1e-17]")))
    few, ends = speckles[:20, :20], "start: [-0.925, 2.025]\ngoal: [-2.0, 2.0]\n"
    with pytest.raises(WorldError, match=r"map\.yaml: goal: .*outside"):
        load_world(write_map(tmp_path, few, MAP + ends))
    np.testing.assert_array_equal(load_world(write_map(tmp_path, few, MAP + ends[:23])).start, [-0.925, 2.025])


PIXELS = [
    ((0, 0, 0), True), ((255, 255, 255), False), ((0, 255, 0), True), ((0, 200, 0), True), ((255, 0, 0), True),
    ((0, 0, 255), True), ((255, 255, 0), False), ((0, 255, 255), False), ((89, 89, 90), False), ((89, 89, 89), True),
]  # fmt: skip


@pytest.mark.parametrize("kind", ["RGB", "P", "RGBA"])
@pytest.mark.parametrize("mode", ["trinary", "scale"])
def test_a_colour_is_the_mean_of_its_channels_as_in_map_server(tmp_path, kind, mode):
    image = Image.new("RGB", (len(PIXELS), 1))
    image.putdata([colour for colour, _ in PIXELS])
    image.convert(kind, palette=Image.Palette.ADAPTIVE).save(tmp_path / "map.png")
    (tmp_path / "map.yaml").write_text(MAP.replace("map.pgm", "map.png") + f"mode: {mode}\n")
    world = load_world(tmp_path / "map.yaml")
    for k, (colour, solid) in enumerate(PIXELS):
        with_opacity = kind == "RGBA" and mode == "trinary"
        shade = (sum(colour) + 255) / 4 if with_opacity else sum(colour) / 3
        expected = 1.0 - shade / 255 > 0.65 if with_opacity else solid
        assert bool(obstacle_at(world, np.array([-1.0 + 0.05 * (k + 0.5), 2.025]))) == expected, colour


@pytest.mark.parametrize("kind", ["RGBA", "LA", "P", "L", "RGB"])
def test_a_transparent_pixel_is_refused_in_every_kind_of_image(tmp_path, kind):
    image = Image.new(kind if kind in ("RGBA", "LA") else "L", (3, 1), 0)
    said = {} if "A" in kind else {"transparency": (0, 0, 0) if kind == "RGB" else 0}
    image.convert(kind).save(tmp_path / "map.png", **said)
    (tmp_path / "map.yaml").write_text(MAP.replace("map.pgm", "map.png"))
    with pytest.raises(WorldError, match=r"image: .*transparent"):
        load_world(tmp_path / "map.yaml")


def test_what_is_no_readable_text_file_is_refused_and_where_none_can_be_written_is_said(tmp_path):
    with pytest.raises(WorldError, match=r"no_such_folder.*written"):
        save_world(load_world("corridor"), tmp_path / "no_such_folder" / "world.yaml")
    (tmp_path / "folder.yaml").mkdir()
    with pytest.raises(WorldError, match=r"folder\.yaml: cannot"):
        load_world(str(tmp_path / "folder.yaml"))
    (tmp_path / "picture.yaml").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(WorldError, match=r"picture\.yaml: .*text"):
        load_world(str(tmp_path / "picture.yaml"))


def test_a_huge_world_is_refused(tmp_path):
    path = tmp_path / "huge.yaml"
    # neither is read as YAML
    for text, said in ((2_000_000 * "\0", "2000000.*1048576"), (10_001 * "[radius", "circles: got 10001.*10000")):
        path.write_text(text)
        with pytest.raises(WorldError, match=rf"huge\.yaml: .*{said}"):
            load_world(str(path))
    with pytest.raises(WorldError, match=r"10001, .*10000"):
        World("huge", (), np.ones((10001, 3)), (0.0, 0.0, 2.0, 2.0))


SEEDS = range(40)
SIDE = 2.4
BODY_RADIUS = 0.09
# coordinates are rounded to 0.1 mm, so a width is off by up to as much
ROUNDING = 1.1e-4

FAMILIES_TESTED = ("l", "u", "z", "serpentine", "baffles", "pillars")
# clear widths beside the robot [m]
NARROWEST = {"l": 0.08, "u": 0.08, "z": 0.08, "baffles": 0.10, "serpentine": 0.15, "pillars": 0.08}
WIDEST = {"l": 0.40, "u": 0.40, "z": 0.40, "baffles": 0.40, "serpentine": 0.30, "pillars": 0.50}


@cache
def worlds_of_family(family: str) -> tuple[World, ...]:
    return tuple(load_world(f"{family}:{seed}") for seed in SEEDS)


def open_space(world: World) -> shapely.Geometry:
    return shapely.box(*world.bounds).difference(shapely.union_all([shapely.Polygon(p) for p in world.polygons]))


def cores(world: World) -> list[tuple[shapely.Geometry, float]]:
    """Each obstacle as a geometry and how far it reaches around it, so that distances to circles are exact."""
    polygons = [(shapely.Polygon(corners), 0.0) for corners in world.polygons]
    return polygons + [(shapely.Point(x, y), radius) for x, y, radius in world.circles]


def gaps(world: World) -> list[float]:
    between = [a.distance(b) - ra - rb for (a, ra), (b, rb) in combinations(cores(world), 2)]
    walls = shapely.box(*world.bounds).exterior
    return between + [shape.distance(walls) - reach for shape, reach in cores(world)]


def test_every_gap_in_random_is_closed_or_lets_the_disc_through_and_opposite_corners_are_connected():
    middle = np.array([1.2, 1.2])
    for world in (load_world(f"random:{seed}") for seed in (*range(12), 2**40)):
        assert not [gap for gap in gaps(world) if 0.0 < gap < 0.2]
        check_route(world, world.start, world.goal, 0.10)
        assert ((world.start - middle) * (world.goal - middle) < 0.0).all()
        assert np.hypot(*(world.goal - world.start)) > 1.2


def test_posts_are_round_thin_and_stand_in_a_wall_or_a_centimetre_more_than_the_robot_apart():
    narrowest = []
    for world in (load_world(f"posts:{seed}") for seed in (*range(12), 2**40)):
        assert (len(world.polygons), 15 <= len(world.circles) <= 40) == (0, True), world.name
        assert 0.03 <= world.circles[:, 2].min() <= world.circles[:, 2].max() <= 0.08
        narrowest.append(min(gap for gap in gaps(world) if gap > 0.0))
        check_route(world, world.start, world.goal, 0.09)
    assert min(narrowest) >= 0.19 - 1e-9
    assert np.median(narrowest) < 0.20  # in most worlds_of_family some gap is hardly wider than the robot


def fingerprint(world: World) -> str:
    arrays = [*world.polygons, world.circles, world.start, world.goal]
    return hashlib.sha256(b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)).hexdigest()


def test_start_and_goal_have_room_and_the_narrowest_place_is_within_the_range_of_widths():
    for world in (world for family in FAMILIES_TESTED for world in worlds_of_family(family)):
        family = world.name.split(":")[0]
        check_route(world, world.start, world.goal, 0.10)
        # three standard deviations of the start's noise
        room = shapely.Point(world.start).distance(shapely.box(0, 0, SIDE, SIDE) - open_space(world))
        assert room > 0.12, world.name
        assert joined(world, BODY_RADIUS + NARROWEST[family] / 2 - ROUNDING, 0.03), world.name
        assert not joined(world, BODY_RADIUS + WIDEST[family] / 2 + ROUNDING, 0.25), world.name


def joined(world: World, radius: float, reach: float) -> bool:
    """Whether a disc, which need not fit at start and goal, gets from within `reach` of one to as near to the other."""
    free, ends = free_space(world, radius), shapely.points([world.start, world.goal])
    return any(shapely.distance(part, ends).max() < reach for part in getattr(free, "geoms", [free]))


def test_a_seed_gives_the_same_world_in_every_process_and_with_every_version_of_numpy():
    """Written down once: whoever changes a family changes every result that names one of its seeds."""
    assert {*FAMILIES} == {*EXPECTED_FINGERPRINTS, "posts"}
    for family, expected in EXPECTED_FINGERPRINTS.items():
        assert load_world(f"{family}:7").name == f"{family}:7"
        assert fingerprint(load_world(f"{family}:7"))[:16] == expected, family
    for family in FAMILIES_TESTED:
        assert len({fingerprint(world) for world in worlds_of_family(family)}) == len(SEEDS), family
    assert fingerprint(load_world(f"l:{2**70}"))[:16] == "c1e859b7a29d9751"


def test_nothing_but_the_corridor_is_free():
    for family, corners in (("l", 6), ("u", 8), ("z", 8), ("serpentine", 16)):
        for world in worlds_of_family(family):
            corridor = open_space(world)
            assert (corridor.geom_type, len(corridor.interiors)) == ("Polygon", 0), world.name
            assert len(corridor.simplify(1e-9).exterior.coords) - 1 == corners, world.name
            assert corridor.distance(shapely.box(*world.bounds).exterior) >= 0.05 - ROUNDING, world.name


EXPECTED_FINGERPRINTS = {
    "random": "42e128e4c98034ee",
    "l": "1ea303d4046fb83d",
    "u": "5ff6305ef91f771d",
    "z": "d4e40453c537fd00",
    "serpentine": "aa1ecc73a5b888e6",
    "baffles": "237d1f6cbb49df04",
    "pillars": "720aca6712931d2d",
}
