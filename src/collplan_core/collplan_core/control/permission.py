"""Permission to act: each decision returns the reason not to act, or "" to go ahead. In doubt the robot stops.

Ages are local time since receipt [s], infinite before the first; stamps are times on the poses' clock [s].
"""

import math
from dataclasses import replace

import numpy as np

from collplan_core.fence import is_outside
from collplan_core.parameters import Limits, LocalMapping, Robot, Settings
from collplan_core.plan import Plan
from collplan_core.scan import Scan
from collplan_core.state import State

TOUCH_MARGIN = 0.01
"""Largest overlap of a seen surface with the robot standing at its goal: noise of poses and ranges [m]."""
_BEARINGS = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
_RING = np.column_stack([np.cos(_BEARINGS), np.sin(_BEARINGS)])
STANDS = np.vstack([np.zeros((1, 2)), *(share * _RING for share in (0.25, 0.5, 0.75, 1.0))])
"""Places (n, 2) at which the robot may stand at its goal, in tolerances from it."""


def why_stale(name: str, age: float, limit: float) -> str:
    """Returns why an input of this age must not be used: too old, never received, or (its clock set back) negative."""
    if math.isinf(age):
        return f"no {name} yet"
    return "" if 0.0 <= age <= limit else f"{name} {age:.2f} s old, limit {limit:.2f} s"


def plan_lifetime(map_period: float) -> float:
    """Returns how long a plan may be followed [s]: long enough for one replanning to fail."""
    return 2.0 * map_period + 0.2


def why_refuse_plan(plan: Plan, goal_stamp: float | None, now: float | None, pose_age: float) -> str:
    """Returns the reason why a plan must not be followed; "" where it may.

    Args:
        goal_stamp: stamp of the active goal [s], None without one; an earlier plan belongs to another goal.
        now: time on the poses' clock [s]; None before the first pose.
        pose_age: time by which a plan may begin later than now [s], limits.pose_age: its pose may arrive that late.
    """
    if goal_stamp is None:
        return "no active goal"
    if now is None:
        return "no pose yet"
    if not plan.stamp > goal_stamp:
        return f"made at {plan.stamp:.3f}, expected later than the goal's {goal_stamp:.3f}"
    if plan.stamp > now + pose_age:
        return f"begins at {plan.stamp:.3f}, it is {now:.3f}"
    return "" if plan.times[-1] > now else f"ended at {plan.times[-1]:.3f}, it is {now:.3f}"


def is_relocated(before: State, after: State, robot: Robot, limits: Limits, leap_margin: float) -> bool:
    """Returns whether two successive poses do not join: a jump, a gap longer than pose_age, or a clock set back.

    Plans and maps from before are then invalid. A jump is a distance of more than `leap_margin` [m]
    (mocap.leap_margin) beyond what excess_speed times the robot's largest speed explains.
    """
    silence = after.stamp - before.stamp
    if not 0.0 <= silence <= limits.pose_age:
        return True
    distance = math.dist(after.position.tolist(), before.position.tolist())
    return distance > limits.excess_speed * robot.fastest * silence + leap_margin


def why_outside(position: np.ndarray, limits: Limits) -> str:
    """Returns the reason why the robot must not move at its position (2,) [m]: outside the fence; "" where it may."""
    outside = is_outside(limits.fence, position)
    return f"the robot at {position[0]:.2f}, {position[1]:.2f} is outside of limits.fence" if outside else ""


def why_refuse_goal(goal: np.ndarray, position: np.ndarray | None, limits: Limits) -> str:
    """Returns why a goal (2,) [m] is refused: goal or robot outside the fence, or too far apart; "" where it is not.

    `position` (2,) of the robot [m] is None where it is not known yet.
    """
    if is_outside(limits.fence, goal):
        return f"{goal[0]:.6g}, {goal[1]:.6g} lies outside of limits.fence"
    if position is None:
        return ""
    distance = math.hypot(*(goal - position))
    if not distance <= limits.goal_distance:
        away = f"{goal[0]:.6g}, {goal[1]:.6g} is {distance:.6g} m away"
        return f"{away}, expected at most {limits.goal_distance:g} m (limits.goal_distance)"
    return why_outside(position, limits)


def is_blocked(goal: np.ndarray, scan: Scan, state: State, settings: Settings, mapping: LocalMapping) -> bool:
    """Returns whether the robot cannot stand within the tolerance of a goal (2,) [m], by a scan taken at `state`.

    Wherever it stood it would overlap a surface within the local map.
    """
    near = np.isfinite(scan.ranges) & (scan.ranges <= mapping.half_side)
    shown = scan.points(state, near)
    radius, tolerance = settings.robot.radius - TOUCH_MARGIN, settings.planner.goal_tolerance
    shown = shown[np.hypot(*(shown - goal).T) < radius + tolerance]
    apart = (goal + tolerance * STANDS)[:, None] - shown
    return bool((np.hypot(apart[..., 0], apart[..., 1]) < radius).any(axis=1).all())


RIM, ALL_AROUND = 0.03, 0.55 * math.pi
"""Beams that end so near to the robot [m] meet parts of it, where no gap between them is wider [rad]."""


def why_shows_itself(scan: Scan, state: State, radius: float) -> str:
    """Returns the sentence on a scan taken at `state` that shows the robot of a radius [m] itself; else "".

    Its beams end inside the robot, or at its rim on all sides, which no wall beside it and no corner does.
    """
    scan = replace(scan, ranges=np.where(scan.ranges == -np.inf, scan.range_min, scan.ranges))
    hits = scan.points(state, np.isfinite(scan.ranges)) - state.position
    apart = np.hypot(*hits.T)
    inside, rim = apart < radius - TOUCH_MARGIN, apart < radius + RIM
    bearings = np.sort(np.arctan2(*hits[rim].T))
    all_around = len(bearings) > 0 and np.diff(bearings, append=bearings[0] + math.tau).max() < ALL_AROUND
    which, where = (inside, "inside the robot") if inside.any() else (rim, "at the robot's rim, on all sides")
    if not (inside.any() or all_around):
        return ""
    found = f"{which.sum()} of {len(scan.ranges)} beams end {where}, from {apart.min():.2f} m from its centre on"
    return f"{found} (robot.radius {radius:g} m): parts of the robot? scan.masked_angles"
