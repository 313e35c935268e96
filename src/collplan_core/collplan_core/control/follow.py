"""The controller: any timed path, contacts and all, by one law. Paper: III-B, Alg. 3.

Reading `follow` is reading the paper's III-B. Before it stand the maneuver for a path that leaves F through an observed
boundary, the references q_bound and q_flow, and the PID with its saturation that keeps the direction.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from collplan_core.command import BOUNDARY_FOLLOWING, FLOW_THROUGH, FREE_SPACE, Command
from collplan_core.control.feed_forward import feed_forward
from collplan_core.control.reference import Reference, found_reference, planned_reference, sample_reference
from collplan_core.jit import njit
from collplan_core.local_map.contact_point import SAME_POINT, ContactPoint, find_contact, passes_through
from collplan_core.local_map.free_space import sector
from collplan_core.local_map.record import LocalMap
from collplan_core.parameters import Control, Limits, Robot, Settings
from collplan_core.plan import Plan
from collplan_core.plane import rotate
from collplan_core.state import State
from collplan_core.velocity_bounds import VelocityBounds, fastest_along, velocity_bounds
from collplan_core.velocity_law import velocity_law

K_I = 1.0
"""Integral gain on the position beside the path [1/s^2]."""
INTEGRAL_LIMIT = 0.2
"""Largest velocity that the integral may add [m/s]."""
K_YAW, MAX_YAW_RATE = 2.0, 1.0
"""Gain that holds the first heading [1/s], and largest yaw rate commanded for it [rad/s]."""
FULL_ACCELERATION_LEAD = 0.6
"""Largest lead of the command over the velocity where the path requires full acceleration [m/s]."""
INCIDENCE_THRESHOLD = math.radians(45.0)
"""Angle between path and boundary below which the boundary is followed [rad]."""
SWITCH_DISTANCE = 0.15
"""delta, distance to the contact point at which a maneuver engages [m]."""


def incidence(contact: ContactPoint) -> float:
    """Angle between the reference and the boundary at the contact, 0 along it, pi/2 square on [rad]."""
    return math.asin(min(1.0, abs(float(contact.direction @ contact.normal))))


def by_incidence(path: np.ndarray, contact: ContactPoint) -> str:
    """The maneuver by angle: contacts flatter than INCIDENCE_THRESHOLD follow the boundary, others flow through."""
    return BOUNDARY_FOLLOWING if incidence(contact) < INCIDENCE_THRESHOLD else FLOW_THROUGH


def by_side_of_chord(path: np.ndarray, contact: ContactPoint) -> str:
    """The maneuver as printed: by the side of the chord WP_1 WP_4 on which p_c lies, so that mirrored worlds differ."""
    chord, to_contact = path[-1] - path[0], contact.point - path[0]
    left = np.array([-chord[1], chord[0]])
    return FLOW_THROUGH if float(left @ to_contact) >= 0.0 else BOUNDARY_FOLLOWING


MANEUVER_RULES = {"incidence": by_incidence, "printed": by_side_of_chord}
"""Alg. 3 for a contact, by controller.maneuver_rule."""


def select_maneuver(path: np.ndarray, contact: ContactPoint | None, control: Control) -> str:
    """Alg. 3 for a reference (n, 2): free_space without a contact, else boundary_following or flow_through."""
    if contact is None:
        return FREE_SPACE
    return MANEUVER_RULES[control.maneuver_rule](path, contact)


SLOW = 0.05
"""A reference slower than this has no direction [m/s]."""


def saturate(velocity: np.ndarray, max_speed: float) -> np.ndarray:
    """The velocity (2,), shortened to max_speed with its direction kept."""
    speed = math.hypot(velocity[0], velocity[1])
    return velocity if speed <= max_speed else velocity * (max_speed / speed)


def cut_to_bounds(velocity: np.ndarray, bounds: VelocityBounds) -> np.ndarray:
    """The velocity (2,), shortened to the bounds with its direction kept."""
    return saturate(velocity, fastest_along(bounds, velocity[0], velocity[1]))


def _without(growth: np.ndarray, cut_off: np.ndarray) -> np.ndarray:
    """A growth (2,) without its part along what is cut off (2,)."""
    along = float(growth.dot(cut_off))
    return growth - along / float(cut_off.dot(cut_off)) * cut_off if along > 0.0 else growth


def pid(
    error: np.ndarray,
    feed_forward: np.ndarray,
    reference_velocity: np.ndarray,
    velocity: np.ndarray,
    integral: np.ndarray,
    control: Control,
    robot: Robot,
    bounds: VelocityBounds,
) -> tuple[np.ndarray, np.ndarray]:
    """World-frame velocity command (2,) [m/s] and the next integral (2,) [m/s].

    What is late along the path is not integrated: mostly no push, but a reference that the wheels cannot keep up with.
    Anti-windup: the integral is limited, and does not grow along what is cut off the command by v_max, or off the
    acceleration that it asks for by the wheels.
    """
    # of two numbers, `dot` gives the bits of @ in a third of its time
    speed2 = float(reference_velocity.dot(reference_velocity))
    aside = error - error.dot(reference_velocity) / max(speed2, SLOW**2) * reference_velocity
    growth = K_I * aside * (1.0 / control.rate)
    wanted = feed_forward + control.k_p * error + integral + growth
    command = cut_to_bounds(wanted, bounds)
    lead = command - velocity
    growth = _without(growth, wanted - command)
    growth = _without(growth, lead - saturate(lead, robot.max_acceleration * robot.velocity_lag))
    return command, saturate(integral + growth, INTEGRAL_LIMIT)


def to_body(velocity: np.ndarray, yaw: float) -> np.ndarray:
    """A world-frame velocity (2,) in the body frame of a robot with that yaw."""
    return np.array(rotate(velocity[0], velocity[1], -yaw))


def hold_heading(yaw: float, held: float) -> float:
    """Yaw rate that leads back to the held heading the short way [rad/s]."""
    error = math.remainder(held - yaw, 2 * math.pi)
    return min(max(K_YAW * error, -MAX_YAW_RATE), MAX_YAW_RATE)


AHEAD = 0.3
"""The view is turned to the place of the plan that is so far ahead [m]."""
NARROWER = 0.5
"""A view of which less is missing has no direction [rad]."""


def look_ahead(plan: Plan, state: State, faces: float, heading: float) -> float:
    """Heading at which the middle of the view, `faces` [rad] seen from the robot, looks where a plan leads [rad].

    `heading` where the plan leads nowhere [rad].
    """
    way = plan.positions[plan.times >= state.stamp] - state.position
    far = np.hypot(*way.T)
    if far.max(initial=0.0) < 0.5 * AHEAD:
        return heading
    x, y = way[int(np.argmax(far >= min(AHEAD, far.max())))].tolist()
    return math.atan2(y, x) - faces


def clip_command(
    velocity: np.ndarray, yaw_rate: float, robot: Robot, limits: Limits
) -> tuple[np.ndarray, float] | None:
    """A command cut to the robot's limits; None (refused) where it is not finite or beyond excess_speed times them."""
    if not (np.isfinite(velocity).all() and math.isfinite(yaw_rate)):
        return None
    most = fastest_along(velocity_bounds(robot), velocity[0], velocity[1])
    too_fast = math.hypot(velocity[0], velocity[1]) > limits.excess_speed * most
    if too_fast or abs(yaw_rate) > limits.excess_speed * robot.max_yaw_rate:
        return None
    return cut_to_limits(velocity, yaw_rate, robot)


def cut_to_limits(velocity: np.ndarray, yaw_rate: float, robot: Robot) -> tuple[np.ndarray, float]:
    """Velocity (2,) [m/s, body frame] and yaw rate [rad/s], both finite, that the robot's limits leave of a command."""
    turn = min(max(yaw_rate, -robot.max_yaw_rate), robot.max_yaw_rate)
    return cut_to_bounds(np.asarray(velocity, dtype=float), velocity_bounds(robot)), turn


GOES_ON = 10.0
"""A boundary is taken to go straight on beyond what was seen of it for so long [m]."""


def _seen_of_boundary(contact: ContactPoint, local_map: LocalMap, extension: float) -> np.ndarray:
    """Boundary seen at a contact, continued along its tangents: (m, 2), counter-clockwise [m]."""
    x, y = contact.point - local_map.position
    n = len(local_map.surface)
    order = (sector(x, y, n) + 1 + np.arange(-n // 2, n // 2)) % n
    order = order[local_map.surface[order] == contact.surface]
    line = local_map.border_points[order]
    tangents = extension * local_map.normals[order[[0, -1]]] @ np.array([[0.0, -1.0], [1.0, 0.0]])
    return np.vstack([line[0] - tangents[0], line, line[-1] + tangents[1]])


@njit
def _projected(line: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Arc lengths (n,) on a line (m, 2) nearest to points (n, 2) [m]; and which points are left of an end piece."""
    pieces, along, left = len(line) - 1, np.empty(len(points)), np.zeros(len(points), np.bool_)
    for i in range(len(points)):
        least, total = math.inf, 0.0
        for k in range(pieces):
            px, py = line[k + 1, 0] - line[k, 0], line[k + 1, 1] - line[k, 1]
            ax, ay = points[i, 0] - line[k, 0], points[i, 1] - line[k, 1]
            length = math.hypot(px, py)
            total += length
            share = (ax * px + ay * py) / max(length, SAME_POINT) ** 2
            share = min(max(share, 0.0), 1.0)
            ax, ay = ax - share * px, ay - share * py
            square = ax * ax + ay * ay
            if square < least:
                least, along[i] = square, total - length + share * length
                left[i] = px * ay - py * ax > 0.0 and (k == 0 or k == pieces - 1)
    return along, left


def boundary_reference(
    times: np.ndarray, path: np.ndarray, contact: ContactPoint, local_map: LocalMap, settings: Settings
) -> tuple[np.ndarray, np.ndarray]:
    """q_bound (n, 2): the reference with what lies beyond the boundary projected onto it; p_d (2,): where that ends.

    It ends with the first sample in F again or, past what was seen of the boundary, in front of where that goes on
    straight. No step of what is projected, nor of the way back from it to the reference, is faster than v_max.
    """
    first, printed = contact.index, settings.controller.boundary_projection == "printed"
    line = _seen_of_boundary(contact, local_map, 0.0 if printed else GOES_ON)
    foot, in_front = _projected(line, np.vstack([path, contact.point]))
    back = (local_map.contains(path) | in_front[:-1])[first:]
    end = first + int(back.argmax()) if back.any() else len(path)
    longest = np.diff(times, prepend=-math.inf) * (math.inf if printed else settings.robot.fastest)
    longest[first] *= max(1.0 - contact.share, SAME_POINT)
    result, along, length = path.copy(), foot[-1], np.append(0.0, np.hypot(*np.diff(line, axis=0).T).cumsum())
    for i in range(first, end):
        along += np.clip(foot[i] - along, -longest[i], longest[i])
        result[i] = [np.interp(along, length, line[:, axis]) for axis in range(2)]
    for i in range(end, len(path)):
        result[i] = result[i - 1] + saturate(path[i] - result[i - 1], longest[i])
    return result, result[end - 1]


def flow_reference(path: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """q_flow: the reference (n, 2) projected onto its chord WP_4 - WP_1, and the chord's end (2,)."""
    chord = path[-1] - path[0]
    length2 = max(float(chord @ chord), 1e-18)
    return path[0] + np.outer((path - path[0]) @ chord / length2, chord), path[-1]


def maneuver_reference(
    maneuver: str, times: np.ndarray, path: np.ndarray, contact: ContactPoint, local_map: LocalMap, settings: Settings
) -> tuple[np.ndarray, np.ndarray]:
    """The reference of a contact maneuver and the point where it is released."""
    if maneuver == FLOW_THROUGH:
        return flow_reference(path)
    return boundary_reference(times, path, contact, local_map, settings)


WAITING, ENGAGED, RELEASED = "waiting", "engaged", "released"


def update_engaged(stage: str, position: np.ndarray, contact_point: np.ndarray, release_point: np.ndarray) -> str:
    """phi: engages within delta of p_c, releases within delta of p_d, and does not engage twice for one contact."""
    if stage == WAITING and float(np.hypot(*(position - contact_point))) <= SWITCH_DISTANCE:
        return ENGAGED
    near_release = float(np.hypot(*(position - release_point))) <= SWITCH_DISTANCE
    passed = float((position - release_point) @ (release_point - contact_point)) >= 0.0
    return RELEASED if stage == ENGAGED and near_release and passed else stage


@dataclass(frozen=True, eq=False)
class ManeuverCourse:
    """One plan as the controller follows it."""

    stamp: float = math.nan  # stamp of the plan [s]
    maneuver: str = FREE_SPACE
    """The maneuver for the contact that the plan's path runs into; FREE_SPACE where there is none."""
    contact_point: np.ndarray | None = None  # engaging point p_c (2,) [m], or None
    release_point: np.ndarray | None = None  # disengaging point p_d (2,) [m], or None
    reference: Reference | None = None  # reference of the plan; None before the first
    contact_reference: Reference | None = None  # reference of the maneuver, or None


@dataclass(frozen=True, eq=False)
class ControllerMemory:
    """The memory that one control period hands to the next."""

    integral: np.ndarray = field(default_factory=lambda: np.zeros(2))
    """(2,) integral of the position error, as a velocity [m/s, world frame]."""
    heading: float | None = None  # yaw that is held [rad]; None until the first pose is seen
    course: ManeuverCourse = field(default_factory=ManeuverCourse)  # the course of the plan in force
    stage: str = WAITING  # stage of its maneuver, phi of the paper's III-B: waiting, engaged or released


TOUCHING = 0.015
"""Distance to a boundary within which the robot may touch it, so that the integral stands still [m]."""


def set_course(plan: Plan, local_map: LocalMap, settings: Settings) -> ManeuverCourse:
    """Alg. 3 for a new plan, with the reference of its maneuver."""
    reference = planned_reference(plan, settings.robot.max_acceleration)
    contact = find_contact(plan.positions, local_map)
    if contact is None or not passes_through(plan.positions, contact, local_map):
        return ManeuverCourse(plan.stamp, reference=reference)
    maneuver = select_maneuver(plan.positions, contact, settings.controller)
    path, release = maneuver_reference(maneuver, plan.times, plan.positions, contact, local_map, settings)
    followed = found_reference(plan.times, path, settings.robot.max_acceleration)
    return ManeuverCourse(plan.stamp, maneuver, contact.point, release, reference, followed)


def _carried_stage(old: ManeuverCourse, new: ManeuverCourse, stage: str) -> str:
    """Returns the stage for a new plan: WAITING, unless its contact point is within delta of the old one."""
    if old.contact_point is None or new.contact_point is None or old.maneuver != new.maneuver:
        return WAITING
    return stage if float(np.hypot(*(old.contact_point - new.contact_point))) <= SWITCH_DISTANCE else WAITING


def _engaged_now(
    memory: ControllerMemory, plan: Plan, local_map: LocalMap, state: State, settings: Settings
) -> ControllerMemory:
    """The memory with the course and the stage of this period. Paper: phi and delta of III-B."""
    course, stage = memory.course, memory.stage
    if course.stamp != plan.stamp:
        course = set_course(plan, local_map, settings)
        stage = _carried_stage(memory.course, course, stage)
    if course.contact_point is not None and course.release_point is not None:
        stage = update_engaged(stage, state.position, course.contact_point, course.release_point)
    return replace(memory, course=course, stage=stage)


@njit
def _touches(border: np.ndarray, surface: np.ndarray, x: float, y: float) -> bool:
    """Tells whether (x, y) is within TOUCHING of an observed boundary: of border points (n, 2) with a surface (n,)."""
    for k in range(len(border)):
        if surface[k] >= 0 and math.hypot(border[k, 0] - x, border[k, 1] - y) < TOUCHING:
            return True
    return False


def follow(
    memory: ControllerMemory, plan: Plan, local_map: LocalMap, state: State, now: float, settings: Settings
) -> tuple[Command, ControllerMemory]:
    """One control period: maneuver, reference, feed-forward, tracking. Paper: III-B.

    `local_map` is of the newest scan that was there when the plan was made. `state` is the newest pose and velocity, or
    where the robot will be when the command acts; `now` is the same time on the poses' clock [s].
    """
    params, robot = settings.controller, settings.robot
    period, bounds = 1.0 / params.rate, velocity_bounds(robot, state.yaw)
    memory = _engaged_now(memory, plan, local_map, state, settings)
    followed, maneuver = memory.course.reference, FREE_SPACE
    if memory.stage == ENGAGED and memory.course.contact_reference is not None:
        followed, maneuver = memory.course.contact_reference, memory.course.maneuver
    assert followed is not None

    reference, reference_velocity = sample_reference(followed, now)
    forward = np.zeros(2)
    if now < plan.times[-1]:
        forward = np.array(feed_forward(followed, now, period, velocity_law(robot), bounds, FULL_ACCELERATION_LEAD))
    velocity, integral = pid(
        reference - state.position,
        forward,
        reference_velocity,
        state.velocity,
        memory.integral,
        params,
        robot,
        bounds,
    )
    if memory.stage == ENGAGED or _touches(local_map.border_points, local_map.surface, *state.position.tolist()):
        integral = memory.integral
    heading = state.yaw if memory.heading is None else memory.heading
    if params.turns_to_look and local_map.unseen.blind > NARROWER:
        heading = look_ahead(plan, state, local_map.unseen.faces, heading)
    command = Command(to_body(velocity, state.yaw), hold_heading(state.yaw, heading), maneuver, reference)
    return command, replace(memory, integral=integral, heading=heading)
