"""Alg. 3, the references of the contact maneuvers, the switch phi, and the controller over plans. Paper: III-B."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from collplan_core.command import BOUNDARY_FOLLOWING, FLOW_THROUGH, FREE_SPACE
from collplan_core.control.follow import (
    ENGAGED,
    INCIDENCE_THRESHOLD,
    RELEASED,
    WAITING,
    ControllerMemory,
    boundary_reference,
    flow_reference,
    follow,
    incidence,
    select_maneuver,
    update_engaged,
)
from collplan_core.local_map.contact_point import find_contact, passes_through
from collplan_core.parameters import Control
from collplan_core.plan import Plan, timed_path
from scenes import (
    RADIUS,
    ROBOT,
    SETTINGS,
    at_rest,
    box,
    cluttered_worlds,
    free_polygon,
    map_of,
    rotation,
    unit,
    world_of,
)

BY_INCIDENCE, AS_PRINTED = Control(), Control(maneuver_rule="printed")
THRESHOLD = INCIDENCE_THRESHOLD
GAP = 0.3


def before_a_wall(turn: float = 0.0):
    return map_of(world_of([box(GAP + RADIUS, -4.0, 2.0, 4.0) @ rotation(turn).T]))


def line(*corners, n: int = 64) -> np.ndarray:
    path = shapely.LineString(corners)
    return np.array([path.interpolate(s, normalized=True).coords[0] for s in np.linspace(0, 1, n)])


def test_by_hand_the_contact_point_is_where_the_reference_meets_the_boundary():
    contact = find_contact(line((0, 0), (0.5, 0.25)), before_a_wall())
    np.testing.assert_allclose(contact.point, [0.3, 0.15], atol=1e-4)
    np.testing.assert_allclose(contact.normal, [-1.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(contact.direction, np.array([2.0, 1.0]) / np.sqrt(5.0), atol=1e-9)
    assert incidence(contact) == pytest.approx(np.arctan2(2.0, 1.0))

    # a reference that stays in F or leaves it through a frontier has none
    local_map = before_a_wall()
    assert find_contact(line((0, 0), (0.25, 0.2)), local_map) is None
    assert find_contact(line((0, 0), (-0.8, 0.1)), local_map) is None


def test_by_hand_flat_contacts_follow_the_boundary_and_square_ones_flow_through():
    for turn, degrees in product(np.radians([0.0, 33.0, 200.0]), (-80.0, -50.0, -40.0, 0.0, 40.0, 50.0, 80.0)):
        slope = np.radians(degrees)
        path = line((0, 0), 0.35 / np.cos(slope) * unit(slope)) @ rotation(turn).T
        contact = find_contact(path, before_a_wall(turn))
        if abs(degrees) > 70.0:
            assert contact is None  # it leaves the map before it meets the wall
        else:
            expected = BOUNDARY_FOLLOWING if abs(slope) > THRESHOLD else FLOW_THROUGH
            assert select_maneuver(path, contact, BY_INCIDENCE) == expected, (turn, degrees)
    assert {select_maneuver(bowed(1.0), None, control) for control in (BY_INCIDENCE, AS_PRINTED)} == {FREE_SPACE}


def bowed(side: float, n: int = 64) -> np.ndarray:
    t = np.linspace(0.0, 1.0, n)[:, None]
    a, b, c, d = np.array([[0.0, 0.0], [0.1, 0.3 * side], [0.4, 0.3 * side], [0.5, 0.0]])
    return (1 - t) ** 3 * a + 3 * t * (1 - t) ** 2 * b + 3 * t**2 * (1 - t) * c + t**3 * d


def test_by_hand_as_printed_the_side_of_the_chord_decides_and_mirrored_worlds_differ():
    """WP_4 - WP_1 is along x; turned left it is along y: p_c on the left flows through, on the right it follows."""
    local_map = before_a_wall()
    left, right = bowed(1.0), bowed(-1.0)
    contacts = find_contact(left, local_map), find_contact(right, local_map)
    assert contacts[0].point[1] > 0.1
    np.testing.assert_allclose(contacts[0].point * [1, -1], contacts[1].point, atol=1e-9)
    printed = [select_maneuver(p, c, AS_PRINTED) for p, c in zip((left, right), contacts, strict=True)]
    assert printed == [FLOW_THROUGH, BOUNDARY_FOLLOWING]
    by_incidence = {select_maneuver(p, c, BY_INCIDENCE) for p, c in zip((left, right), contacts, strict=True)}
    assert len(by_incidence) == 1


@given(world=cluttered_worlds(), aim=st.tuples(st.floats(-0.8, 0.8), st.floats(-0.8, 0.8)).map(np.array))
def test_contact_lies_on_the_border_and_up_to_it_the_reference_is_as_it_was(world, aim):
    local_map = map_of(world)
    assume(local_map.position @ local_map.position == 0.0)
    path = line((0, 0), 0.5 * aim + [0.02, 0.01], aim)
    contact = find_contact(path, local_map)
    assume(contact is not None)
    free = free_polygon(local_map)
    assert free.exterior.distance(shapely.Point(contact.point)) < 1e-5
    assert (local_map.contains(path[: contact.index])).all()
    assert np.hypot(*contact.normal) == pytest.approx(1.0)
    projected, release = q_bound(path, contact, local_map)
    np.testing.assert_array_equal(projected[: contact.index], path[: contact.index])
    assert (projected == release).all(axis=1).any()


def q_bound(path, contact, local_map, settings=SETTINGS):
    """The reference of a path (n, 2) that is gone along at v_max."""
    times = np.arange(len(path)) * np.hypot(*np.diff(path, axis=0).T).max() / ROBOT.max_speed
    return boundary_reference(times, path, contact, local_map, settings)


@given(
    world=cluttered_worlds(),
    points=st.lists(st.tuples(st.floats(-0.8, 0.8), st.floats(-0.8, 0.8)), min_size=2, max_size=4, unique=True),
    shares=st.lists(st.floats(0.01, 1.0), min_size=63, max_size=63),
)
def test_q_bound_never_jumps_and_is_released_on_the_boundary_or_where_it_goes_straight_on(world, points, shares):
    local_map = map_of(world)
    assume(local_map.position @ local_map.position == 0.0)
    places = np.cumsum([0.0, *shares])
    path = np.array(
        [shapely.LineString([(0, 0), *points]).interpolate(s / places[-1], normalized=True).coords[0] for s in places]
    )
    contact = find_contact(path, local_map)
    assume(contact is not None)
    times = np.cumsum([0.0, *np.maximum(np.hypot(*np.diff(path, axis=0).T) / ROBOT.max_speed, 1e-6)])
    projected, release = boundary_reference(times, path, contact, local_map, SETTINGS)
    steps = np.hypot(*np.diff(projected, axis=0).T)
    assert (steps <= ROBOT.max_speed * np.diff(times) + 1e-6).all()
    seen = local_map.border_points[local_map.surface == contact.surface]
    normals = local_map.normals[local_map.surface == contact.surface]
    off = np.abs(((release - seen) * normals).sum(axis=1))
    nearest = np.hypot(*(release - seen).T).min()
    assert min(off.min(), nearest) < 0.02


def test_by_hand_q_bound_runs_along_the_wall_to_where_the_reference_ends_or_comes_back():
    local_map = before_a_wall()
    for corners, left in (([(0, 0), (0.4, 0.4)], None), ([(0, 0), (0.35, 0.2), (0.1, 0.4)], 1)):
        path = line(*corners)
        projected, release = q_bound(path, find_contact(path, local_map), local_map)
        outside = path[:, 0] > 0.3
        np.testing.assert_allclose(projected[~outside], path[~outside], atol=1e-12)
        np.testing.assert_allclose(projected[outside, 0], 0.3, atol=1e-9)
        np.testing.assert_allclose(projected[outside, 1], path[outside, 1], atol=1e-9)
        expected = projected[np.flatnonzero(outside)[-1]] if left else [0.3, 0.4]
        np.testing.assert_allclose(release, expected, atol=1e-9)


def test_by_hand_past_the_end_of_what_is_seen_q_bound_goes_straight_on_and_as_printed_it_rests_and_jumps():
    local_map = before_a_wall()
    path = line((0, 0), (0.36, 0.2), (0.36, 0.75), (0.2, 0.75))
    contact, ahead = find_contact(path, local_map), np.hypot(*np.diff(path, axis=0).T).max()
    followed, release = q_bound(path, contact, local_map)
    steps = np.hypot(*np.diff(followed, axis=0).T)
    assert steps.max() <= ahead + 1e-9
    np.testing.assert_allclose(release, [0.3, 0.75], atol=0.02)
    printed = SETTINGS.with_values({"controller.boundary_projection": "printed"})
    jumps, release = q_bound(path, contact, local_map, printed)
    np.testing.assert_allclose(release, [0.3, 0.6], atol=0.02)
    steps = np.hypot(*np.diff(jumps, axis=0).T)
    assert (steps < 1e-9).sum() > 10


def test_by_hand_q_flow_is_the_projection_onto_the_chord():
    path = bowed(1.0)
    projected, end = flow_reference(path)
    np.testing.assert_allclose(projected, path * [1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(end, path[-1])


CONTACT, RELEASE = np.array([1.0, 0.0]), np.array([2.0, 0.0])


def test_by_hand_phi():
    table = [
        (WAITING, 0.80, WAITING),
        (WAITING, 0.86, ENGAGED),
        (WAITING, 1.14, ENGAGED),
        (ENGAGED, 0.50, ENGAGED),
        (ENGAGED, 1.50, ENGAGED),
        (ENGAGED, 2.10, RELEASED),
        (RELEASED, 1.00, RELEASED),
        (RELEASED, 0.00, RELEASED),
    ]
    for stage, x, after in table:
        assert update_engaged(stage, np.array([x, 0.0]), CONTACT, RELEASE) == after, (stage, x)


def test_by_hand_a_path_that_comes_back_passes_through_only_where_it_is_deep():
    local_map = before_a_wall()
    for depth, through in ((0.02, False), (0.04, False), (0.06, True), (0.3, True)):
        path = line((0, -0.1), (GAP + depth, 0.0), (0, 0.1))
        assert passes_through(path, find_contact(path, local_map), local_map) == through, depth
        ending = line((0, 0), (GAP + depth, 0.1))
        assert passes_through(ending, find_contact(ending, local_map), local_map)
    # what is seen of a wall ends at x = 0.6
    local_map = map_of(world_of([box(-4.0, -4.0, 4.0, -0.1 - RADIUS)]))
    for depth, through in ((0.002, False), (0.016, True)):
        clip = line((0, 0), (0.6, -0.1 - depth), (1.3, -0.3))
        assert passes_through(clip, find_contact(clip, local_map), local_map) == through, depth


LOCAL_MAP = map_of(world_of([box(GAP + RADIUS, -4.0, 2.0, 4.0)]))
"""A wall whose grown face lies at x = 0.3."""
INTO_WALL, ALONG_WALL = (0.35, 0.1), (0.35, 0.55)


def plan_to(end, stamp: float = 0.0, start=(0.0, 0.0), duration: float = 1.0) -> Plan:
    share = np.linspace(0.0, 1.0, 64)[:, None]
    start, end = np.array(start, dtype=float), np.array(end, dtype=float)
    velocities = np.broadcast_to((end - start) / duration, (64, 2))
    plan = timed_path(stamp, stamp + duration * share[:, 0], start + share * (end - start), velocities)
    return replace(plan, aim_velocity=np.zeros(2))


def step(memory, plan, position=(0.0, 0.0), now=0.0, yaw=0.0, settings=SETTINGS, local_map=LOCAL_MAP):
    return follow(memory, plan, local_map, at_rest(position, yaw), now, settings)


def test_a_contact_maneuver_engages_within_delta_of_the_contact_point():
    for end, maneuver, reference in [
        (INTO_WALL, FLOW_THROUGH, lambda p: p),
        (ALONG_WALL, BOUNDARY_FOLLOWING, lambda p: np.array([min(p[0], GAP), p[1]])),
    ]:
        plan = plan_to(end)
        at_contact = np.array(end) * GAP / end[0]
        back = np.array(end) / np.hypot(*end)
        memory = ControllerMemory()
        command, memory = step(memory, plan, at_contact - 0.16 * back, now=0.9)
        assert command.maneuver == FREE_SPACE, (end, maneuver, reference)
        command, memory = step(memory, plan, at_contact - 0.14 * back, now=0.9)
        assert command.maneuver == maneuver, (end, maneuver, reference)
        np.testing.assert_allclose(command.reference, reference(0.9 * np.array(end)), atol=1e-6)


def test_the_integral_stands_still_in_a_maneuver_and_at_a_boundary_and_takes_what_is_beside_the_path():
    along_wall = plan_to((0.0, 0.5))
    for memory, plan, position, grows in [
        (ControllerMemory(), along_wall, (-0.02, 0.2), True),
        (ControllerMemory(), along_wall, (0.0, 0.22), False),  # late alone
        (ControllerMemory(), plan_to((0.3, 0.5), start=(0.3, -0.5)), (GAP - 0.005, 0.0), False),
        (engaged_on(plan_to(INTO_WALL)), plan_to(INTO_WALL), (0.2, 0.1), False),
    ]:
        _, after = step(memory, plan, position, now=0.5)
        assert (np.abs(after.integral).max() > 1e-6) == grows, (position, grows)


def engaged_on(plan, settings=SETTINGS) -> ControllerMemory:
    command, memory = step(ControllerMemory(), plan, (0.2, 0.05), now=plan.stamp + 0.5, settings=settings)
    assert command.maneuver == FLOW_THROUGH
    return memory


def test_a_new_plan_keeps_the_stage_where_its_contact_is_near_the_old_one_alone():
    # far from the contact, where nothing would engage anew
    for end, maneuver in (((0.4, 0.15), FLOW_THROUGH), ((0.4, 0.4), FREE_SPACE), ((0.0, 0.4), FREE_SPACE)):
        command, _ = step(engaged_on(plan_to(INTO_WALL)), plan_to(end, stamp=0.2), (0.0, 0.0), now=0.3)
        assert command.maneuver == maneuver, end


@given(yaw=st.floats(-4.0, 4.0), x=st.floats(-0.5, 0.5), y=st.floats(-0.5, 0.5), now=st.floats(0.0, 2.0))
def test_the_command_is_in_the_body_frame_and_within_v_max(yaw, x, y, now):
    plan = plan_to((-0.4, 0.3))
    straight, _ = step(ControllerMemory(), plan, (x, y), now=now)
    turned, memory = step(ControllerMemory(), plan, (x, y), now=now, yaw=yaw)
    np.testing.assert_allclose(rotation(yaw) @ turned.velocity, straight.velocity, atol=1e-9)
    assert np.hypot(*turned.velocity) <= SETTINGS.robot.max_speed * (1 + 1e-9)
    assert memory.heading == yaw
