"""The maneuver-switching controller: reading `follow` top to bottom is reading the paper's III-B."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from collplan_core.command import FREE_SPACE, Command
from collplan_core.control.memory import ControllerMemory
from collplan_core.control.tracking import hold_heading, pid, sample_reference, to_body
from collplan_core.local_map.record import LocalMap
from collplan_core.paper_planner.maneuver import find_contact, select_maneuver
from collplan_core.paper_planner.references import ENGAGED, WAITING, maneuver_reference, update_engaged
from collplan_core.parameters import Control, Settings
from collplan_core.plan import Plan
from collplan_core.state import State


@dataclass(frozen=True, eq=False)
class Course:
    """One plan as the controller sees it: its spline, and the maneuver for the contact it runs into, if any."""

    stamp: float = math.nan
    maneuver: str = FREE_SPACE
    contact_point: np.ndarray | None = None
    release_point: np.ndarray | None = None
    contact_path: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Engagement:
    """The course of the plan in force, and the stage of its maneuver: phi of III-B."""

    course: Course = field(default_factory=Course)
    stage: str = WAITING


def set_course(plan: Plan, plan_map: LocalMap, control: Control) -> Course:
    """Alg. 3 for a new plan, with the reference of its maneuver."""
    contact = find_contact(plan.positions, plan_map)
    if contact is None:
        return Course(stamp=plan.stamp)
    maneuver = select_maneuver(plan.positions, contact, control)
    path, release = maneuver_reference(maneuver, plan.positions, contact, plan_map)
    return Course(plan.stamp, maneuver, contact.point, release, path)


def _carried_stage(old: Course, new: Course, stage: str, switch_distance: float) -> str:
    """A new plan resets phi unless its contact point is within delta of the old one."""
    if old.contact_point is None or new.contact_point is None or old.maneuver != new.maneuver:
        return WAITING
    return stage if float(np.hypot(*(old.contact_point - new.contact_point))) <= switch_distance else WAITING


def _engaged_now(engagement: Engagement, plan: Plan, plan_map: LocalMap, state: State, control: Control) -> Engagement:
    """The engagement after this period's position. Paper: phi and delta of III-B."""
    course, stage = engagement.course, engagement.stage
    if course.stamp != plan.stamp:
        course = set_course(plan, plan_map, control)
        stage = _carried_stage(engagement.course, course, stage, control.switch_distance)
    if course.contact_point is not None and course.release_point is not None:
        stage = update_engaged(
            stage, state.position, course.contact_point, course.release_point, control.switch_distance
        )
    return Engagement(course, stage)


def follow(
    memory: ControllerMemory, plan: Plan, plan_map: LocalMap, state: State, now: float, settings: Settings
) -> tuple[Command, ControllerMemory]:
    """One control period: maneuver, reference, tracking. Paper: III-B.

    Args:
        plan_map: the local map of the plan's own scan.
        state: the newest pose and velocity.
        now: time on the poses' clock [s].
    """
    params = settings.controller
    engagement = _engaged_now(memory.follower or Engagement(), plan, plan_map, state, params)
    path, maneuver = plan.positions, FREE_SPACE
    if engagement.stage == ENGAGED and engagement.course.contact_path is not None:
        path, maneuver = engagement.course.contact_path, engagement.course.maneuver

    reference, feed_forward = sample_reference(plan.times, path, now, params.look_ahead)
    velocity, integral = pid(
        reference - state.position,
        feed_forward,
        feed_forward - state.velocity,
        memory.integral,
        1.0 / params.rate,
        params,
        settings.robot.max_speed,
    )
    heading = state.yaw if memory.heading is None else memory.heading
    command = Command(to_body(velocity, state.yaw), hold_heading(state.yaw, heading, params), maneuver, reference)
    return command, replace(memory, integral=integral, heading=heading, follower=engagement)
