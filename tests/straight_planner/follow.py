"""Following a straight plan: its velocity, and a push back onto it."""

from dataclasses import replace

import numpy as np

from collplan_core.command import FREE_SPACE, Command
from collplan_core.control.memory import ControllerMemory
from collplan_core.control.tracking import hold_heading, sample_reference, saturate, to_body
from collplan_core.local_map import LocalMap
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.state import State


def follow(
    memory: ControllerMemory, plan: Plan, plan_map: LocalMap | None, state: State, now: float, settings: Settings
) -> tuple[Command, ControllerMemory]:
    """One control period."""
    params = settings.controller
    reference, velocity = sample_reference(plan.times, plan.positions, now, params.look_ahead)
    wanted = saturate(velocity + params.k_p * (reference - state.position), settings.robot.max_speed)
    heading = state.yaw if memory.heading is None else memory.heading
    yaw_rate = hold_heading(state.yaw, heading, params)
    command = Command(np.asarray(to_body(wanted, state.yaw)), yaw_rate, FREE_SPACE, reference)
    return command, replace(memory, heading=heading)
