"""The maneuver-switching controller over hand-made plans. Paper: III-B."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.command import BOUNDARY_FOLLOWING, FLOW_THROUGH, FREE_SPACE
from collplan_core.control.follow import follow
from collplan_core.control.memory import ControllerMemory
from collplan_core.plan import Candidates, Contacts, Plan
from scenes import RADIUS, SETTINGS, at_rest, box, map_of, rotation, world_of

GAP = 0.3
LOCAL_MAP = map_of(world_of([box(GAP + RADIUS, -4.0, 2.0, 4.0)]))
"""A wall whose grown face lies at x = 0.3."""
INTO_WALL, ALONG_WALL = (0.35, 0.1), (0.35, 0.55)


def plan_to(end, stamp: float = 0.0, start=(0.0, 0.0), duration: float = 1.0) -> Plan:
    share = np.linspace(0.0, 1.0, 64)[:, None]
    start, end = np.array(start, dtype=float), np.array(end, dtype=float)
    return Plan(
        stamp=stamp,
        times=stamp + duration * share[:, 0],
        positions=start + share * (end - start),
        velocities=np.broadcast_to((end - start) / duration, (64, 2)),
        contacts=Contacts.none(),
        aim=end,
        aim_velocity=np.zeros(2),
        terms={},
        candidates=Candidates(end[None], np.zeros((1, 2)), np.zeros(1)),
        n_before_pruning=1,
    )


def step(memory, plan, position=(0.0, 0.0), now=0.0, yaw=0.0, settings=SETTINGS, local_map=LOCAL_MAP):
    return follow(memory, plan, local_map, at_rest(position, yaw), now, settings)


def test_in_free_space_the_spline_is_tracked():
    command, memory = step(ControllerMemory(), plan_to((0.0, 0.5)), (0.02, 0.2), now=0.5)
    np.testing.assert_allclose(command.reference, [0.0, 0.25], atol=1e-9)
    np.testing.assert_allclose(command.velocity, [4 * -0.02, 0.5 + 4 * 0.05], atol=1e-6)
    assert command.maneuver == FREE_SPACE
    assert memory.heading == 0.0
    assert command.yaw_rate == 0.0


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


def engaged_on(plan, settings=SETTINGS) -> ControllerMemory:
    command, memory = step(ControllerMemory(), plan, (0.2, 0.05), now=plan.stamp + 0.5, settings=settings)
    assert command.maneuver == FLOW_THROUGH
    return memory


def test_a_new_plan_with_its_contact_near_the_old_one_keeps_the_stage():
    memory = engaged_on(plan_to(INTO_WALL))
    # far from the contact, where nothing would engage anew
    command, _ = step(memory, plan_to((0.4, 0.15), stamp=0.2), (0.0, 0.0), now=0.3)
    assert command.maneuver == FLOW_THROUGH


def test_a_new_plan_with_its_contact_elsewhere_or_without_one_resets_the_stage():
    for end in [(0.4, 0.4), (0.0, 0.4)]:
        memory = engaged_on(plan_to(INTO_WALL))
        command, _ = step(memory, plan_to(end, stamp=0.2), (0.0, 0.0), now=0.3)
        assert command.maneuver == FREE_SPACE, end


def test_a_released_contact_does_not_engage_again():
    plan = plan_to(INTO_WALL)
    memory = engaged_on(plan)
    command, memory = step(memory, plan, (0.42, 0.105), now=1.0)
    assert command.maneuver == FREE_SPACE
    command, _ = step(memory, plan, (0.25, 0.06), now=1.0)
    assert command.maneuver == FREE_SPACE


@settings(derandomize=True, deadline=None, max_examples=40, print_blob=True)
@given(yaw=st.floats(-4.0, 4.0), x=st.floats(-0.5, 0.5), y=st.floats(-0.5, 0.5), now=st.floats(0.0, 2.0))
def test_the_command_is_in_the_body_frame_and_within_v_max(yaw, x, y, now):
    plan = plan_to((-0.4, 0.3))
    straight, _ = step(ControllerMemory(), plan, (x, y), now=now)
    turned, memory = step(ControllerMemory(), plan, (x, y), now=now, yaw=yaw)
    np.testing.assert_allclose(rotation(yaw) @ turned.velocity, straight.velocity, atol=1e-9)
    assert np.hypot(*turned.velocity) <= SETTINGS.robot.max_speed * (1 + 1e-9)
    assert memory.heading == yaw


def test_the_first_heading_is_held():
    _, memory = step(ControllerMemory(), plan_to((0.0, 0.5)), yaw=3.1)
    command, _ = step(memory, plan_to((0.0, 0.5)), yaw=-3.1)
    assert command.yaw_rate == pytest.approx(-SETTINGS.controller.k_yaw * (2 * np.pi - 6.2))
