"""The maneuver-switching controller: reading `control` top to bottom is reading the paper's III-B."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from collplan_core.command import FREE_SPACE, Command
from collplan_core.local_map.record import LocalMap
from collplan_core.maneuver import find_contact, select_maneuver
from collplan_core.params import Control, Settings
from collplan_core.plan import Plan
from collplan_core.references import ENGAGED, WAITING, maneuver_reference, update_engaged
from collplan_core.state import State
from collplan_core.strategies import rolls_out
from collplan_core.tracking import hold_heading, pid, rollout_feed_forward, sample_reference, to_body


@dataclass(frozen=True, eq=False)
class Course:
    """One plan as the controller sees it: its spline, and the maneuver for the contact it runs into, if any."""

    stamp: float = math.nan
    maneuver: str = FREE_SPACE
    contact_point: np.ndarray | None = None
    release_point: np.ndarray | None = None
    contact_path: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class ControllerMemory:
    """What the controller keeps between two periods."""

    course: Course = field(default_factory=Course)
    stage: str = WAITING
    integral: np.ndarray = field(default_factory=lambda: np.zeros(2))
    heading: float | None = None

    @staticmethod
    def fresh() -> "ControllerMemory":
        """Nothing known yet; the first yaw seen is held."""
        return ControllerMemory()


def set_course(plan: Plan, plan_map: LocalMap, control: Control) -> Course:
    """Alg. 3 for a new plan, with the reference of its maneuver."""
    contact = find_contact(plan.positions, plan_map)
    if contact is None:
        return Course(stamp=plan.stamp)
    maneuver = select_maneuver(plan.positions, contact, control.incidence_threshold, control.maneuver_rule)
    path, release = maneuver_reference(maneuver, plan.positions, contact, plan_map)
    return Course(plan.stamp, maneuver, contact.point, release, path)


def _carried_stage(old: Course, new: Course, stage: str, switch_distance: float) -> str:
    """A new plan resets phi unless its contact point is within delta of the old one."""
    if old.contact_point is None or new.contact_point is None or old.maneuver != new.maneuver:
        return WAITING
    return stage if float(np.hypot(*(old.contact_point - new.contact_point))) <= switch_distance else WAITING


def _follow_rollout(
    memory: ControllerMemory, plan: Plan, state: State, now: float, settings: Settings
) -> tuple[Command, ControllerMemory]:
    params, robot = settings.controller, settings.robot
    reference, _ = sample_reference(plan.times, plan.positions, now, 0.0)
    feed_forward = np.zeros(2)
    if now < plan.times[-1]:
        feed_forward = np.array(
            rollout_feed_forward(
                plan.times,
                plan.positions,
                now,
                1.0 / params.rate,
                max(robot.velocity_lag, 1e-3),
                robot.max_acceleration,
            )
        )
    velocity, integral = pid(
        reference - state.position, feed_forward, np.zeros(2), memory.integral, 1.0 / params.rate, params,
        robot.max_speed,
    )  # fmt: skip
    heading = state.yaw if memory.heading is None else memory.heading
    command = Command(to_body(velocity, state.yaw), hold_heading(state.yaw, heading, params), FREE_SPACE, reference)
    return command, replace(memory, course=Course(plan.stamp), stage=WAITING, integral=integral, heading=heading)


def control(memory: ControllerMemory, plan: Plan, plan_map: LocalMap | None, state: State, now: float,
            settings: Settings) -> tuple[Command, ControllerMemory]:  # fmt: skip
    """One period: maneuver, reference, tracking. Paper: III-B. A rollout is followed as it is, contacts and all.

    Args:
        plan_map: the local map of the plan's own scan; not needed to follow a rollout.
        state: the newest pose and velocity.
        now: time on the poses' clock [s].
    """
    if plan_map is None or rolls_out(settings):
        return _follow_rollout(memory, plan, state, now, settings)
    params = settings.controller
    if memory.course.stamp != plan.stamp:
        course = set_course(plan, plan_map, params)
        stage = _carried_stage(memory.course, course, memory.stage, params.switch_distance)
        memory = replace(memory, course=course, stage=stage)
    course, stage = memory.course, memory.stage
    if course.contact_point is not None and course.release_point is not None:
        stage = update_engaged(
            stage, state.position, course.contact_point, course.release_point, params.switch_distance
        )
    engaged = stage == ENGAGED and course.contact_path is not None
    path = course.contact_path if engaged and course.contact_path is not None else plan.positions

    reference, feed_forward = sample_reference(plan.times, path, now, params.look_ahead)
    velocity, integral = pid(
        reference - state.position, feed_forward, feed_forward - state.velocity, memory.integral,
        1.0 / params.rate, params, settings.robot.max_speed,
    )  # fmt: skip
    heading = state.yaw if memory.heading is None else memory.heading
    command = Command(
        velocity=to_body(velocity, state.yaw),
        yaw_rate=hold_heading(state.yaw, heading, params),
        maneuver=course.maneuver if engaged else FREE_SPACE,
        reference=reference,
    )
    return command, replace(memory, stage=stage, integral=integral, heading=heading)
