"""The controller: any timed path, contacts and all, by one law. Reading `follow` is reading the paper's III-B.

The feed-forward comes from the path alone; a path that reflects at a contact is followed as it is; a path that goes on
beyond an observed boundary is followed by the maneuver for it.
"""

from dataclasses import replace

import numpy as np

from collplan_core.command import FREE_SPACE, Command
from collplan_core.control.feed_forward import feed_forward
from collplan_core.control.maneuver import select_maneuver
from collplan_core.control.memory import ControllerMemory, ManeuverCourse
from collplan_core.control.references import ENGAGED, WAITING, maneuver_reference, update_engaged
from collplan_core.control.tracking import hold_heading, pid, sample_reference, to_body
from collplan_core.local_map.contact_point import find_contact, passes_through
from collplan_core.local_map.record import LocalMap
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.state import State
from collplan_core.velocity_law import velocity_law

TOUCHING = 0.015
"""Distance to a boundary within which the robot may touch it, so that the integral stands still [m]."""


def set_course(plan: Plan, local_map: LocalMap, settings: Settings) -> ManeuverCourse:
    """Alg. 3 for a new plan, with the reference of its maneuver."""
    contact = find_contact(plan.positions, local_map)
    if contact is None or not passes_through(plan.positions, contact, local_map):
        return ManeuverCourse(stamp=plan.stamp)
    maneuver = select_maneuver(plan.positions, contact, settings.controller)
    path, release = maneuver_reference(maneuver, plan.times, plan.positions, contact, local_map, settings)
    return ManeuverCourse(plan.stamp, maneuver, contact.point, release, path)


def _carried_stage(old: ManeuverCourse, new: ManeuverCourse, stage: str, switch_distance: float) -> str:
    """Returns the stage for a new plan: WAITING, unless its contact point is within delta of the old one."""
    if old.contact_point is None or new.contact_point is None or old.maneuver != new.maneuver:
        return WAITING
    return stage if float(np.hypot(*(old.contact_point - new.contact_point))) <= switch_distance else WAITING


def _engaged_now(
    memory: ControllerMemory, plan: Plan, local_map: LocalMap, state: State, settings: Settings
) -> ControllerMemory:
    """The memory with the course and the stage of this period. Paper: phi and delta of III-B."""
    course, stage, delta = memory.course, memory.stage, settings.controller.switch_distance
    if course.stamp != plan.stamp:
        course = set_course(plan, local_map, settings)
        stage = _carried_stage(memory.course, course, stage, delta)
    if course.contact_point is not None and course.release_point is not None:
        stage = update_engaged(stage, state.position, course.contact_point, course.release_point, delta)
    return replace(memory, course=course, stage=stage)


def _touches(local_map: LocalMap, position: np.ndarray) -> bool:
    """Tells whether the robot is within TOUCHING of an observed boundary."""
    away = local_map.border_points[local_map.surface >= 0] - position
    return bool((np.hypot(*away.T) < TOUCHING).any())


def follow(
    memory: ControllerMemory, plan: Plan, local_map: LocalMap, state: State, now: float, settings: Settings
) -> tuple[Command, ControllerMemory]:
    """One control period: maneuver, reference, feed-forward, tracking. Paper: III-B.

    Args:
        local_map: the local map of the newest scan that was there when the plan was made.
        state: the newest pose and velocity, or where the robot will be when the command acts.
        now: the same time on the poses' clock [s].
    """
    params, robot = settings.controller, settings.robot
    period = 1.0 / params.rate
    memory = _engaged_now(memory, plan, local_map, state, settings)
    path, maneuver = plan.positions, FREE_SPACE
    if memory.stage == ENGAGED and memory.course.contact_path is not None:
        path, maneuver = memory.course.contact_path, memory.course.maneuver

    reference, reference_velocity = sample_reference(plan.times, path, now)
    forward = np.zeros(2)
    if now < plan.times[-1]:
        wheels = velocity_law(robot)
        forward = np.array(
            feed_forward(plan.times, path, now, period, wheels, robot.max_speed, params.full_acceleration_lead)
        )
    velocity, integral = pid(
        reference - state.position,
        forward,
        reference_velocity,
        state.velocity,
        memory.integral,
        period,
        params,
        robot,
    )
    if memory.stage == ENGAGED or _touches(local_map, state.position):
        integral = memory.integral
    heading = state.yaw if memory.heading is None else memory.heading
    command = Command(to_body(velocity, state.yaw), hold_heading(state.yaw, heading, params), maneuver, reference)
    return command, replace(memory, integral=integral, heading=heading)
