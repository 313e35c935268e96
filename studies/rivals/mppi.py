"""MPPI of pytorch_mppi as a planner: a sequence of commands, shifted and made better each control interval.

Its rollouts are those of the project's own planner: dynamics, contacts, costs and time to go are the same functions.
Only how commands are chosen is another.
"""

from typing import Any

import numpy as np
import torch
from pytorch_mppi import MPPI

from collplan_core.deadline import never
from collplan_core.jit import njit
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.planners import Planner
from collplan_core.state import State
from collplan_core.time_to_goal_planner.arrival import ON_THE_WAY, is_there, roll_interval, to_go
from collplan_core.time_to_goal_planner.dynamics import Motion, motion_at
from collplan_core.time_to_goal_planner.initial_state import Expected, initial_velocity
from collplan_core.time_to_goal_planner.model import CONTROL_INTERVAL, Constants, Problem
from collplan_core.velocity_bounds import within
from collplan_core.worlds import World
from rivals.known_problem import known_problem, plan_along

SAMPLES, HORIZON = 2000, 30
"""Sequences tried in a cycle, and control intervals in each."""
TEMPERATURE = 0.01
"""Difference of cost that counts [s]."""
SPREAD = 0.5
"""Standard deviation of a command's component [m/s]."""
FIRST = 10
"""Rounds before the robot moves; one in each cycle then."""


@njit
def roll_each(
    clearance: np.ndarray, source: np.ndarray, constants: Constants, states: np.ndarray, commands: np.ndarray
) -> None:
    """Takes rollouts (k, 5), x, y, vx, vy and cost so far, one control interval on, each under its command (k, 2)."""
    grid, goal, _, _, bounds = constants
    for k, row in enumerate(states):
        begin = motion_at(clearance, grid, row[0], row[1], row[2], row[3])
        if not is_there(goal, begin):
            ux, uy = within(bounds, commands[k, 0], commands[k, 1])
            end, cost, arrival = roll_interval(clearance, source, constants, begin, ux, uy)
            row[0], row[1], row[2], row[3] = end.x, end.y, end.vx, end.vy
            row[4] += cost + (CONTROL_INTERVAL if arrival == ON_THE_WAY else arrival)


@njit
def whole_costs(problem: Problem, states: np.ndarray) -> np.ndarray:
    """(k,) cost of rollouts that end in states (k, 5), with the time to go from there [s]."""
    costs = states[:, 4].copy()
    for k, row in enumerate(states):
        costs[k] += to_go(problem, Motion(row[0], row[1], row[2], row[3], 0.0, 0))
    return costs


def mppi_planner(world: World, settings: Settings) -> Planner:
    """A planner for one run in a world that it knows, with the contacts and costs of `planner.strategy`."""
    torch.set_num_threads(1)
    torch.set_default_dtype(torch.double)
    torch.manual_seed(0)
    problem = known_problem(world, settings)

    def dynamics(states: torch.Tensor, commands: torch.Tensor) -> torch.Tensor:
        after = states.numpy().copy()
        roll_each(problem.clearance, problem.source, problem.constants, after, commands.numpy())
        return torch.from_numpy(after)

    mppi = MPPI(
        dynamics,
        # what an interval costs is in the state
        lambda states, commands: torch.zeros(len(states)),
        nx=5,
        noise_sigma=SPREAD**2 * torch.eye(2),
        num_samples=SAMPLES,
        horizon=HORIZON,
        lambda_=TEMPERATURE,
        u_max=torch.full((2,), problem.constants.bounds.max_speed),
        U_init=torch.zeros(HORIZON, 2),
        terminal_state_cost=lambda states, commands: torch.from_numpy(whole_costs(problem, states[0, :, -1].numpy())),
    )

    def plan(
        memory: Any, local_map: Any, state: State, goal: Any, settings: Settings, deadline: Any = never
    ) -> tuple[Plan, Expected]:
        place = [*state.position.tolist(), *initial_velocity(state, memory, settings.mocap).tolist()]
        initial = motion_at(problem.clearance, problem.constants.grid, *place)
        begin = torch.tensor([*place, 0.0])
        if memory is not None:
            mppi.u_init = mppi.U[-1]
            mppi.shift_nominal_trajectory()
        for _ in range(FIRST if memory is None else 1):
            mppi.command(begin, shift_nominal_trajectory=False)
        commands = np.array([within(problem.constants.bounds, ux, uy) for ux, uy in mppi.U.tolist()])
        made = plan_along(problem, initial, commands, state.stamp, settings.robot.radius)
        assert made.velocities is not None
        return made, Expected(made.times, made.positions, made.velocities, made.contacts.times)

    return Planner(plan, CONTROL_INTERVAL)
