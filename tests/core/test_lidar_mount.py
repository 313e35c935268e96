"""A LIDAR that is not at the robot's centre, or that moves while it sweeps: every beam begins where it was."""

import math
from dataclasses import replace

import numpy as np
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from collplan_core.control.permission import is_blocked
from collplan_core.local_map import build_local_map
from collplan_core.local_map.free_space import UNSEEN_SURFACE
from collplan_core.loop.refusals import Refusals
from collplan_core.loop.sensors import Sensors
from collplan_core.parameters import Lidar, LocalMapping, ScanInput, Settings
from collplan_core.scan import Scan
from collplan_core.sensing.beam_poses import placed_among
from collplan_core.sensing.felt_obstacles import with_felt
from collplan_core.sensing.spinning_lidar import LD19
from collplan_core.sensing.sweeps import Sweeps
from collplan_core.state import State
from collplan_core.worlds import World
from collplan_core.worlds.raycast import simulate_scan
from scenes import RADIUS, ROBOT, at_rest, box, cluttered_worlds, free_polygon, grown, obstacles, world_of

QUICK = settings(derandomize=True, deadline=None, max_examples=25, print_blob=True)
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
    """What planner and controller make of the scan of a LIDAR that is where they believe it to be."""
    scan = simulate_scan(world, state, Lidar(n_beams=n_beams, **mount))
    return placed_among(scan, state, [state], ScanInput(**mount))


def distances(scan: Scan, state: State) -> np.ndarray:
    return shapely.distance(shapely.points(scan.points(state, np.isfinite(scan.ranges))), WALLS)


@QUICK
@given(state=poses, mount=mounts)
def test_every_hit_is_on_a_wall_wherever_the_lidar_is_mounted(state, mount):
    assert distances(placed(ROOM, state, mount), state).max() < 1e-6


@QUICK
@given(state=poses, mount=mounts, wrong=st.sampled_from(["offset_x", "offset_y", "offset_yaw", "mirrored"]))
def test_a_wrong_mount_puts_hits_off_the_walls(state, mount, wrong):
    believed = {
        **mount,
        wrong: not mount[wrong] if wrong == "mirrored" else mount[wrong] - math.copysign(0.05, mount[wrong]),
    }
    scan = simulate_scan(ROOM, state, Lidar(**mount))
    assert distances(placed_among(scan, state, [state], ScanInput(**believed)), state).max() > 0.01


def test_a_lidar_at_the_centre_is_seen_from_the_robot_to_the_last_bit():
    state = at_rest((0.1, -0.2), 0.7)
    scan = simulate_scan(ROOM, state, Lidar())
    assert placed_among(scan, state, [state], ScanInput()) is scan
    angles = scan.angles + state.yaw
    points = state.position + scan.ranges[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    assert scan.points(state, np.isfinite(scan.ranges)).tobytes() == points.tobytes()


@QUICK
@given(world=cluttered_worlds(), mount=mounts)
def test_free_space_from_beside_the_centre_is_free(world, mount):
    """None of it is nearer to an obstacle than the robot's radius, but for what falls between two beams."""
    solid = obstacles(world)
    centre = np.array([mount["offset_x"], mount["offset_y"]])
    assume(solid.is_empty or solid.distance(shapely.Point(0.0, 0.0)) > RADIUS + 1e-6)
    assume(solid.is_empty or solid.distance(shapely.Point(centre)) > 0.025)
    state = at_rest()
    seen = build_local_map(placed(world, state, mount, 1000), state, ROBOT, LocalMapping())
    if not solid.is_empty:
        rim = shapely.points(shapely.get_coordinates(free_polygon(seen).segmentize(0.01)))
        assert RADIUS - shapely.distance(solid, rim).min() < 0.01
    # and it is not less than what the robot sees from its centre, but for the shadows, which begin elsewhere
    central = build_local_map(simulate_scan(world, state, Lidar(n_beams=1000)), state, ROBOT, LocalMapping())
    lost = free_polygon(central).difference(free_polygon(seen))
    assert lost.area < 0.12 * free_polygon(central).area + 0.01
    assert shapely.difference(free_polygon(seen), grown(world, RADIUS - 0.01)).area > 0.85 * free_polygon(seen).area


def test_what_a_lidar_ahead_of_the_centre_cannot_see_behind_it_is_not_free():
    state, mount = at_rest(), {"offset_x": 0.06}
    scan = simulate_scan(world_of(), state, Lidar(angle_min=-2.356, angle_span=4.712, n_beams=271, **mount))
    seen = build_local_map(placed_among(scan, state, [state], ScanInput(**mount)), state, ROBOT, LocalMapping())
    directions = 2.0 * np.pi * np.arange(len(seen.reach)) / len(seen.reach)
    ahead, behind = np.cos(directions) > 0.1, np.cos(directions) < -0.9
    assert (seen.reach[ahead] > 0.5).all()
    assert (seen.reach[behind] == 0.0).all()
    assert (seen.surface[behind] == UNSEEN_SURFACE).all()


def test_a_goal_is_blocked_and_a_felt_disc_is_seen_where_they_are():
    state, mount = at_rest((0.1, 0.0), 0.4), {"offset_x": -0.07, "offset_y": 0.05, "offset_yaw": 1.0}
    scan = placed(world_of([box(0.4, -0.1, 0.6, 0.1)]), state, mount)
    for x in (0.4 - RADIUS - 0.01, 0.4 - RADIUS + 0.02):
        assert is_blocked(np.array([x, 0.0]), scan, state, ROBOT, LocalMapping()) == (x > 0.4 - RADIUS)
    felt = with_felt(scan, state, np.array([[-0.3, 0.1]]), RADIUS)
    changed = felt.ranges != scan.ranges
    ends = felt.points(state, changed)
    np.testing.assert_allclose(np.hypot(*(ends - (-0.3, 0.1)).T), RADIUS, atol=1e-9)
    assert changed.sum() > 10


# ---- a sweep


def bounced(stamp: float) -> State:
    """A robot that runs at 1 m/s, is thrown back by an impact at 0.35 s, and turns all the while."""
    along = stamp if stamp < 0.35 else 0.35 - 0.7 * (stamp - 0.35)
    return State(stamp, np.array([along - 0.3, 0.1]), np.array([1.0 if stamp < 0.35 else -0.7, 0.0]), 1.5 * stamp)


def test_the_sweep_is_undone_across_an_impact():
    """Poses at 100 Hz, one of them the impact's own: each hit of each sweep is on a wall."""
    mount = {"offset_x": 0.05, "offset_y": -0.03, "offset_yaw": 0.5}
    sweeps, sensors = Sweeps(ROOM, NEVER_WRONG, Lidar(**mount), 0), Sensors(0.5, Refusals())
    values = Settings().with_values({f"scan.{key}": value for key, value in mount.items()})
    judged = []
    for step in range(61):
        state = bounced(0.01 * step)
        sensors.take_pose(state, state.stamp, values)
        scan = sweeps.take_pose(state)
        if scan is not None:
            sensors.take_scan(scan, state.stamp, values)
            shown, at = sensors.newest_placed()
            assert shown.stamp == scan.stamp
            judged.append(distances(shown, at).max())
            still = replace(shown, sensor_poses=np.tile(shown.sensor_poses[0], (len(shown.ranges), 1)))
            assert distances(still, at).max() > 0.05
    assert len(judged) == 5
    assert max(judged) < 1e-6


@QUICK
@given(x=st.floats(-0.8, 0.8), mount=mounts)
def test_a_sweep_of_a_robot_that_moves_gives_free_space_that_is_free(x, mount):
    def moving(stamp):
        return State(stamp, np.array([x * stamp - 0.1, 0.1]), np.array([x, 0.0]), 2.0 * stamp)

    sweeps = Sweeps(ROOM, NEVER_WRONG, Lidar(**mount), 0)
    states = [moving(0.01 * step) for step in range(12)]
    (scan,) = [scan for scan in map(sweeps.take_pose, states) if scan is not None]
    placed_scan = placed_among(scan, states[0], states, ScanInput(**mount))
    seen = build_local_map(placed_scan, states[0], ROBOT, LocalMapping())
    rim = shapely.points(shapely.get_coordinates(free_polygon(seen).segmentize(0.01)))
    assert RADIUS - shapely.distance(obstacles(ROOM), rim).min() < 0.015
    assert free_polygon(seen).area > 0.25


def test_beams_in_the_other_order_give_the_same_map():
    sweeps = Sweeps(ROOM, NEVER_WRONG, Lidar(), 0)
    states = [bounced(0.25 + 0.01 * step) for step in range(12)]
    (scan,) = [scan for scan in map(sweeps.take_pose, states) if scan is not None]
    last = scan.stamp + scan.time_increment * (len(scan.ranges) - 1)
    turned = Scan(
        last,
        scan.angles[-1],
        -scan.angle_increment,
        scan.range_min,
        scan.range_max,
        scan.ranges[::-1],
        -scan.time_increment,
    )
    centre = ScanInput()
    at_last = bounced(last)
    maps = [
        build_local_map(placed_among(each, at_last, states, centre), at_last, ROBOT, LocalMapping())
        for each in (replace(scan, sensor_poses=None), turned)
    ]
    np.testing.assert_allclose(maps[0].reach, maps[1].reach, atol=2e-3)
    assert math.isfinite(maps[0].reach.sum())
