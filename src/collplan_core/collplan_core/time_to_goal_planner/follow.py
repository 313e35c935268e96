"""Following a rollout as it is, contacts and all."""

import numpy as np

from collplan_core.command import FREE_SPACE, Command
from collplan_core.control.memory import ControllerMemory
from collplan_core.control.tracking import hold_heading, pid, sample_reference, to_body
from collplan_core.local_map.record import LocalMap
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.state import State
from collplan_core.time_to_goal_planner.feed_forward import feed_forward
from collplan_core.velocity_law import velocity_law


def follow(
    memory: ControllerMemory, plan: Plan, plan_map: LocalMap | None, state: State, now: float, settings: Settings
) -> tuple[Command, ControllerMemory]:
    """One control period: the command that drives the path, and tracking of what is left.

    Args:
        plan_map: not needed.
        state: the newest pose and velocity.
        now: time on the poses' clock [s].
    """
    params, robot = settings.controller, settings.robot
    period = 1.0 / params.rate
    reference, _ = sample_reference(plan.times, plan.positions, now, 0.0)
    forward = np.zeros(2)
    if now < plan.times[-1]:
        forward = np.array(feed_forward(plan.times, plan.positions, now, period, velocity_law(robot)))
    velocity, integral = pid(
        reference - state.position, forward, np.zeros(2), memory.integral, period, params, robot.max_speed
    )
    heading = state.yaw if memory.heading is None else memory.heading
    command = Command(to_body(velocity, state.yaw), hold_heading(state.yaw, heading, params), FREE_SPACE, reference)
    return command, ControllerMemory(integral, heading)
