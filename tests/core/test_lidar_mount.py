"""A LIDAR that is not at the centre, sweeps and errs: every beam begins where it was."""

from dataclasses import replace
from math import hypot, pi, sqrt, tau

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from collplan_core.local_map import build_local_map
from collplan_core.loop.sensed_scans import SensedScans
from collplan_core.parameters import Lidar, LocalMapping, ScanInput, Settings
from collplan_core.scan import Scan
from collplan_core.scans.filters import in_time
from collplan_core.scans.placing import placed_among
from collplan_core.state import State
from collplan_core.worlds import World
from collplan_core.worlds.instant_lidar import InstantLidar
from collplan_core.worlds.raycast import simulate_scan
from collplan_core.worlds.spinning_lidar import LD19, Sweeps, blended, noisy, sweeps_of
from scenes import RADIUS, ROBOT, at_rest, box, cluttered_worlds, free_polygon, grown, obstacles, scan_of, world_of

NEVER_WRONG = replace(LD19, noise=0.0, noise_share=0.0, lost=0.0, divergence=0.0)
ROOM = world_of([box(0.5, -0.3, 0.8, 0.2), box(-0.9, 0.4, -0.5, 0.7)], bounds=(-1.5, -1.2, 1.4, 1.3), walled=True)
WALLS = shapely.union_all([solid.boundary for solid in [shapely.box(-1.5, -1.2, 1.4, 1.3)]] + [
    shapely.Polygon(corners).boundary for corners in ROOM.polygons
])  # fmt: skip

offsets = st.floats(-0.08, 0.08)
mounts = st.builds(
    lambda x, y, yaw, mirrored: {"offset_x": x, "offset_y": y, "offset_yaw": yaw, "mirrored": mirrored},
    offsets,
    offsets,
    st.floats(-3.1, 3.1),
    st.booleans(),
)
poses = st.builds(at_rest, st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3)), st.floats(-3.1, 3.1))


def placed(world: World, state: State, mount: dict, n_beams: int = 360) -> Scan:
    scan = simulate_scan(world, state, Lidar(n_beams=n_beams, **mount))
    return placed_among(scan, state, [state], ScanInput(**mount))


def distances(scan: Scan, state: State) -> np.ndarray:
    return shapely.distance(shapely.points(scan.points(state, np.isfinite(scan.ranges))), WALLS)


@given(state=poses, mount=mounts)
def test_every_hit_is_on_a_wall_wherever_the_lidar_is_mounted(state, mount):
    assert distances(placed(ROOM, state, mount), state).max() < 1e-6


@given(world=cluttered_worlds(), mount=mounts)
def test_free_space_from_beside_the_centre_is_free(world, mount):
    solid = obstacles(world)
    centre = np.array([mount["offset_x"], mount["offset_y"]])
    assume(solid.is_empty or solid.distance(shapely.Point(0.0, 0.0)) > RADIUS + 1e-6)
    assume(solid.is_empty or solid.distance(shapely.Point(centre)) > 0.025)
    state = at_rest()
    seen = build_local_map(placed(world, state, mount, 1000), state, ROBOT, LocalMapping())
    if not solid.is_empty:
        border = seen.border_points
        sides = shapely.linestrings(np.stack([border, np.roll(border, -1, axis=0)], axis=1))
        # a shadow edge passes a corner between one direction and the next
        corner = np.minimum(np.hypot(*border.T), np.hypot(*np.roll(border, -1, axis=0).T)) + RADIUS
        allowed = np.where(seen.shadow, np.maximum(0.01, corner * tau / len(border)), 0.01)
        assert (RADIUS - shapely.distance(solid, sides) < allowed).all()
    assert shapely.difference(free_polygon(seen), grown(world, RADIUS - 0.01)).area > 0.85 * free_polygon(seen).area


def bounced(stamp: float) -> State:
    along = stamp if stamp < 0.35 else 0.35 - 0.7 * (stamp - 0.35)
    return State(stamp, np.array([along - 0.3, 0.1]), np.array([1.0 if stamp < 0.35 else -0.7, 0.0]), 1.5 * stamp)


@pytest.mark.parametrize(("sweep", "offset"), [("forwards", 0.0), ("backwards", -0.17), ("instant", 0.05)])
def test_the_sweep_is_undone_across_an_impact_whatever_its_order_and_its_stamp(sweep, offset):
    mount = {"offset_x": 0.05, "offset_y": -0.03, "offset_yaw": 0.5, "stamp_offset": offset}
    sweeps, sensors = Sweeps(ROOM, NEVER_WRONG, Lidar(**mount, sweep=sweep), 0), SensedScans(0.5)
    told = mount | {"backwards": sweep == "backwards", "instant": sweep == "instant"}
    values = Settings().with_values({f"scan.{key}": value for key, value in told.items()})
    judged = []
    for step in range(61):
        state = bounced(0.01 * step)
        sensors.take_pose(state, state.stamp, values)
        scan = sweeps.take_pose(state)
        if scan is not None:
            assert scan.stamp <= state.stamp + 1e-9
            sensors.take_scan(in_time(scan, values.scan), state.stamp, values)
            shown, at = sensors.newest_placed()
            assert shown.stamp == in_time(scan, values.scan).stamp
            judged.append(distances(shown, at).max())
            still = replace(shown, sensor_poses=np.tile(shown.sensor_poses[0], (len(shown.ranges), 1)))
            assert (distances(still, at).max() > 0.05) == (sweep != "instant")
    assert len(judged) in (4, 5)
    assert max(judged) < 1e-6


SQUARE = world_of(bounds=(-1.0, -1.0, 1.0, 1.0), walled=True)


def instant(noise: float, seed: int = 3) -> InstantLidar:
    return InstantLidar(SQUARE, Lidar(range_noise=noise), seed)


def test_noise_has_its_deviation_and_equal_seeds_give_equal_scans():
    errors = instant(0.01).scan(at_rest()).ranges - scan_of(SQUARE, at_rest()).ranges
    assert errors.std() == pytest.approx(0.01, rel=0.15)
    assert np.isneginf(instant(0.01).scan(at_rest((2.0, 0.0))).ranges).all()
    lidar, again, other = instant(0.01), instant(0.01), instant(0.01, seed=4)
    first = lidar.scan(at_rest()).ranges.tobytes()
    assert first == again.scan(at_rest()).ranges.tobytes()
    assert first not in (other.scan(at_rest()).ranges.tobytes(), lidar.scan(at_rest()).ranges.tobytes())
    assert instant(0.0).scan(at_rest()).ranges.tobytes() == scan_of(SQUARE, at_rest()).ranges.tobytes()


DRAWS = 200_000


def room(*polygons) -> World:
    corners = tuple(np.array(polygon, dtype=float) for polygon in polygons)
    return World("room", corners, np.zeros((0, 3)), (-3.0, -3.0, 3.0, 3.0), True)


def random(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def driving(stamp: float) -> State:
    return State(stamp, np.array([-0.5 + 0.9 * stamp, 0.3 * stamp]), np.array([0.9, 0.3]), 2.5 * stamp)


def scans_of(sweeps: Sweeps, stamps, motion=driving):
    """Each scan with the stamp of the pose it came with."""
    pairs = [(float(stamp), sweeps.take_pose(motion(float(stamp)))) for stamp in stamps]
    return [(stamp, scan) for stamp, scan in pairs if scan is not None]


def test_noise_has_the_deviation_of_the_record_and_so_many_beams_are_lost():
    for distance in (0.3, 1.0, 11.0):
        measured = noisy(np.full(DRAWS, distance), LD19, random())
        deviation = hypot(LD19.noise, LD19.noise_share * distance)
        # four standard errors of a mean, of a standard deviation and of a share
        assert np.nanmean(measured) == pytest.approx(distance, abs=4 * deviation / sqrt(DRAWS)), distance
        assert np.nanstd(measured) == pytest.approx(deviation, rel=4 / sqrt(2 * DRAWS)), distance
        assert np.isnan(measured).mean() == pytest.approx(LD19.lost, abs=4 * sqrt(LD19.lost / DRAWS)), distance
    beams, sound = np.array([np.inf, -np.inf]), replace(LD19, lost=0.0)
    np.testing.assert_array_equal(noisy(beams, sound, random()), beams)
    assert noisy(np.full(DRAWS, 0.005), sound, random()).min() == 0.0


@given(near=st.floats(0.3, 1.5), gap=st.floats(0.05, 1.4), turn=st.floats(-1.0, 1.0))
def test_a_beam_on_an_edge_lies_between_the_two_surfaces(near, gap, turn):
    far = near + gap
    # both end where the beam along x passes; the far one lies behind the near one's edge
    world = room(
        [[near, -0.5], [near + 0.01, -0.5], [near + 0.01, 0.0], [near, 0.0]],
        [[far, -0.5], [far + 0.01, -0.5], [far + 0.01, 0.5], [far, 0.5]],
    )
    offset = 0.4 * turn * LD19.divergence
    mixed = blended(world, np.zeros((1, 2)), np.array([offset]), LD19)[0]
    assert near < mixed < far * 1.001
    assert mixed - near > 0.1 * gap
    assert far - mixed > 0.1 * gap
    # a quarter turn aside it meets one surface
    assert blended(world, np.zeros((1, 2)), np.array([pi]), LD19)[0] == pytest.approx(3.0, rel=1e-4)


def test_after_silence_or_a_clock_set_a_sweep_begins_anew():
    for jump in [-5.0, 0.4, 100.0]:
        sweeps = Sweeps(room(), LD19, Lidar(), 0)
        before = np.arange(0.0, 0.16, 0.01)
        assert len(scans_of(sweeps, before, lambda t: replace(driving(0.0), stamp=t))) == 1, jump
        after = 0.15 + jump + np.arange(0.0, 0.25, 0.01)
        (came, scan), *_ = scans_of(sweeps, after, lambda t: replace(driving(0.0), stamp=t))
        assert scan.stamp == pytest.approx(after[0]), jump
        assert came == pytest.approx(after[0] + LD19.sweep_time + LD19.latency, abs=0.0101), jump


@pytest.mark.parametrize("sensor", ["ideal", "low_cost"])
def test_a_fault_of_the_lidar_is_in_its_ranges_and_nowhere_else(sensor):
    world, stamps = world_of([box(-10.0, 0.3, 10.0, 0.5)]), np.arange(0.0, 0.6, 0.01)
    scans = {}
    for fault in ("none", "flat", "zeros", "repeats"):
        lidar = Lidar(sensor=sensor, fault=fault, range_max=12.0)
        sweeps, at_once = sweeps_of(world, lidar, 0), InstantLidar(world, lidar, 0)
        given = map(sweeps.take_pose if sweeps else at_once.scan, map(driving, stamps[:: 1 if sweeps else 5]))
        scans[fault] = [scan for scan in given if scan is not None]
    sound, flat, zeros, again = (each[1] for each in scans.values())
    instants = sound.stamp + sound.time_increment * np.arange(len(sound.ranges))
    angles = abs(np.sin(2.5 * instants + sound.angles))
    open_now = np.isinf(flat.ranges) & np.isfinite(sound.ranges)
    assert open_now.sum() > 10
    assert angles[open_now].max() < 0.2
    np.testing.assert_array_equal(zeros.ranges, np.where(np.isfinite(sound.ranges), sound.ranges, 0.0))
    kept = [scan.ranges.tobytes() for scan in scans["repeats"]]
    assert len(set(kept)) < 0.8 * len(kept)
    assert len({scan.stamp for scan in scans["repeats"]}) == len(kept)
    assert again.stamp == sound.stamp
