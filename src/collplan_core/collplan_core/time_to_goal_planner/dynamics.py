"""One step of the robot's dynamics, with the first contact in it."""

from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.reflection import Ring, reflect
from collplan_core.time_to_goal_planner.boundary_memory.clearance import (
    INFERRED,
    OBSERVED,
    PENDING,
    Grid,
    clearance_at,
    normal_at,
    source_at,
)
from collplan_core.time_to_goal_planner.model import (
    CONTROL_INTERVAL,
    EXCLUDED,
    EXCLUDED_BY_SPEED,
    IMPACT_SPEED,
    STEP,
    ContactCosts,
    RobotModel,
)
from collplan_core.velocity_law import Course, VelocityLaw, course_after_step, course_to, velocity_after

NO_CONTACT, SLIDES = 0, 4
"""Kinds of contact beside OBSERVED and INFERRED."""


class Motion(NamedTuple):
    """Position [m] and velocity [m/s] of the disc's centre, world frame, and a lower bound of its clearance [m]."""

    x: float
    y: float
    vx: float
    vy: float
    clearance_bound: float
    steps: int  # number of steps since the plan began


class Contact(NamedTuple):
    """The first contact within a step."""

    kind: int  # NO_CONTACT, SLIDES, OBSERVED or INFERRED
    normal_speed: float  # speed into the boundary [m/s]
    share: float  # part of the step that lies before it
    nx: float  # nx, ny: unit normal out of the boundary
    ny: float


NOTHING_TOUCHED = Contact(NO_CONTACT, 0.0, 0.0, 0.0, 0.0)


@njit
def motion_at(clearance: np.ndarray, grid: Grid, x: float, y: float, vx: float, vy: float, steps: int = 0) -> Motion:
    """The motion through (x, y) at (vx, vy) after some steps of a plan, its clearance read from the field."""
    return Motion(x, y, vx, vy, clearance_at(clearance, grid, x, y), steps)


@njit
def course_of(motion: Motion, ux: float, uy: float) -> Course:
    """The course of a motion's velocity to command u [m/s]."""
    return course_to(motion.vx, motion.vy, ux, uy)


@njit
def free_step(wheels: VelocityLaw, motion: Motion, course: Course) -> tuple[Motion, Course]:
    """The motion and its course after STEP where nothing is in the way; a bound below 0 means it was not looked."""
    x, y, vx, vy, bound, steps = motion
    course = course_after_step(wheels, course)
    wx, wy = course.ux + course.gap * course.ex, course.uy + course.gap * course.ey
    dx, dy = 0.5 * (vx + wx) * STEP, 0.5 * (vy + wy) * STEP
    # no component of a step is longer than the step
    return Motion(x + dx, y + dy, wx, wy, bound - abs(dx) - abs(dy), steps + 1), course


@njit
def step(
    clearance: np.ndarray, source: np.ndarray, grid: Grid, model: RobotModel, motion: Motion, course: Course
) -> tuple[Motion, Course, Contact]:
    """The motion after STEP on its course, the course then, and the first contact on the way.

    What a contact does to the velocity is in `_step_with_contact`.
    """
    end, onward = free_step(model.wheels, motion, course)
    if end.clearance_bound > 0.0:
        return end, onward, NOTHING_TOUCHED
    after = clearance_at(clearance, grid, end.x, end.y)
    end = Motion(end.x, end.y, end.vx, end.vy, after, end.steps)
    if after >= 0.0:
        return end, onward, NOTHING_TOUCHED
    stopped, contact = _step_with_contact(clearance, source, grid, model, motion, end, course.ux, course.uy)
    return stopped, course_of(stopped, course.ux, course.uy), contact


@njit
def _step_with_contact(
    clearance: np.ndarray,
    source: np.ndarray,
    grid: Grid,
    model: RobotModel,
    motion: Motion,
    end: Motion,
    ux: float,
    uy: float,
) -> tuple[Motion, Contact]:
    """A step that meets a boundary: motion up to the contact, and on under u for the rest of the step."""
    # At the contact, above IMPACT_SPEED, the rebound of a disc without spin (`reflect`); below it the normal speed is
    # removed. By a late contact what is pending has stood, or is known not to.
    share = _contact_share(clearance, grid, motion, end)
    cx, cy = motion.x + share * (end.x - motion.x), motion.y + share * (end.y - motion.y)
    nx, ny = normal_at(clearance, grid, cx, cy)
    sx, sy = motion.vx + share * (end.vx - motion.vx), motion.vy + share * (end.vy - motion.vy)
    normal_speed = -(sx * nx + sy * ny)
    kind, rx, ry = SLIDES, sx, sy
    if normal_speed > IMPACT_SPEED:
        what = source_at(source, grid, cx, cy)
        too_soon = what == PENDING and motion.steps * STEP < model.stood_by
        kind = INFERRED if what == INFERRED or too_soon else OBSERVED
        restitution = model.ring.restitution if kind == OBSERVED else 0.0
        ring = Ring(restitution, model.ring.friction, model.ring.inertia_factor, model.ring.body_share)
        rx, ry, _ = reflect(sx, sy, 0.0, nx, ny, ring)
    elif normal_speed > 0.0:
        rx, ry = sx + normal_speed * nx, sy + normal_speed * ny
    rest = (1.0 - share) * STEP
    wx, wy = velocity_after(model.wheels, rx, ry, ux, uy, rest)
    pressed = -(wx * nx + wy * ny)
    if kind == SLIDES and pressed > 0.0:
        wx, wy = wx + pressed * nx, wy + pressed * ny
    px, py = cx + 0.5 * (rx + wx) * rest, cy + 0.5 * (ry + wy) * rest
    measured = clearance_at(clearance, grid, px, py)
    if measured < 0.0:
        # of another wall where it ends beyond that
        out_x, out_y = normal_at(clearance, grid, px, py)
        px, py = px - measured * out_x, py - measured * out_y
    bound = 0.0 if measured < 0.0 else measured
    return Motion(px, py, wx, wy, bound, end.steps), Contact(kind, normal_speed, share, nx, ny)


@njit
def _contact_share(clearance: np.ndarray, grid: Grid, motion: Motion, end: Motion) -> float:
    """Share of a step into a boundary after which it touches that, by one step of false position."""
    before, after = clearance_at(clearance, grid, motion.x, motion.y), end.clearance_bound
    if before <= 1e-4:
        return 0.0
    share = before / (before - after)
    # the clearance bends at corners
    middle = clearance_at(clearance, grid, motion.x + share * (end.x - motion.x), motion.y + share * (end.y - motion.y))
    if middle > 0.0:
        return share + (1.0 - share) * middle / (middle - after)
    return share * (before / (before - middle))


@njit
def contact_cost(costs: ContactCosts, contact: Contact) -> float:
    """Returns the cost of a contact [s]: above any detour where it is excluded, and rising with its speed."""
    speed = contact.normal_speed
    if contact.kind == OBSERVED:
        cost = costs.fixed + costs.by_speed * speed
    elif contact.kind == INFERRED:
        cost = costs.inferred_fixed + costs.inferred_by_speed * speed
    else:
        return 0.0
    return cost + (EXCLUDED + EXCLUDED_BY_SPEED * (speed - costs.limit) if speed > costs.limit else 0.0)


@njit
def margin_cost(clearance: np.ndarray, grid: Grid, costs: ContactCosts, end: Motion) -> float:
    """Cost of a control interval that ends within the margin of a boundary without touching it [s]."""
    within = costs.margin - clearance_at(clearance, grid, end.x, end.y)
    return costs.near * CONTROL_INTERVAL * within * within if within > 0.0 else 0.0
