"""SST of OMPL: the state is place, velocity and time, the cost is time, and nothing may be touched.

OMPL measures how near two states are by place and velocity alone. Time has weight 0 there. Each motion is computed by
the project's own compiled dynamics. OMPL calls it through its Python bindings.
"""

import math
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from time import process_time
from typing import Any

import numpy as np

from collplan_core.deadline import never
from collplan_core.jit import njit
from collplan_core.parameters import Settings
from collplan_core.plan import Plan, timed_path
from collplan_core.planners import Planner
from collplan_core.state import State
from collplan_core.time_to_goal_planner.arrival import ON_THE_WAY, roll_interval
from collplan_core.time_to_goal_planner.boundary_memory.clearance import clearance_at
from collplan_core.time_to_goal_planner.dynamics import Motion, motion_at
from collplan_core.time_to_goal_planner.model import CONTROL_INTERVAL, STEP, Constants, Problem
from collplan_core.velocity_bounds import within
from collplan_core.worlds import World
from rivals.known_problem import known_problem, plan_along

VELOCITY_WEIGHT = 0.2
"""Weight of a difference of velocity beside a distance [s]."""
SELECTION, PRUNING = 0.1, 0.05
"""Radii of SST, in the same measure [m]."""
LONGEST_CONTROL = 8
"""Control intervals for which one command holds, at most."""
LONGEST = 60.0
"""Longest motion [s]."""


@njit
def drive(
    clearance: np.ndarray,
    source: np.ndarray,
    constants: Constants,
    state: tuple[float, ...],
    ux: float,
    uy: float,
    count: int,
) -> tuple[Motion, float]:
    """The motion from x, y, vx, vy after a command for control intervals, and its time [s], inf within the margin."""
    grid, costs, bounds = constants.grid, constants.costs, constants.bounds
    motion, took = motion_at(clearance, grid, state[0], state[1], state[2], state[3]), 0.0
    ux, uy = within(bounds, ux, uy)
    for _ in range(count):
        motion, cost, arrival = roll_interval(clearance, source, constants, motion, ux, uy)
        there = arrival != ON_THE_WAY
        if clearance_at(clearance, grid, motion.x, motion.y) < costs.margin or (cost > 0.0 and not there):
            return motion, math.inf
        took += arrival if there else CONTROL_INTERVAL
        if there:
            break
    return motion, took


def search(world: World, settings: Settings, seconds: float) -> tuple[Plan | None, float, int]:
    """The best motion found in so many seconds of the processor's time, from time 0; None without one.

    Also what planning took [s], the map's preparation left out, and how many motions were computed. In a process of its
    own: a seed counts once in each, and OMPL's bindings crash where Python ends.
    """
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(_search, world, settings, seconds).result()


def _search(world: World, settings: Settings, seconds: float) -> tuple[Plan | None, float, int]:
    from ompl import base

    problem, counted = known_problem(world, settings), [0]
    setup = _setup(problem, world, counted)
    begun, plan = process_time(), None
    until = base.PlannerTerminationConditionFn(lambda: process_time() - begun > seconds)
    setup.solve(base.PlannerTerminationCondition(until))
    took = process_time() - begun
    if setup.haveExactSolutionPath():
        x, y = np.asarray(world.start).tolist()
        initial = motion_at(problem.clearance, problem.constants.grid, x, y, 0.0, 0.0)
        path = setup.getSolutionPath()
        controls = [path.getControl(k) for k in range(path.getControlCount())]
        commands = [within(problem.constants.bounds, u[0], u[1]) for u in controls for _ in range(int(u[2]))]
        plan = plan_along(problem, initial, np.array(commands), 0.0, settings.robot.radius)
    return plan, took, counted[0]


def _setup(problem: Problem, world: World, counted: list[int]) -> Any:
    """OMPL's planner with its problem; counts the motions that it computes."""
    from ompl import base, control, util

    util.RNG.setSeed(1)
    util.setLogLevel(util.LOG_ERROR)
    clearance, source, constants = problem.clearance, problem.source, problem.constants
    goal, top, (x0, y0, x1, y1) = constants.goal, constants.bounds.max_speed, world.bounds
    space = base.CompoundStateSpace()
    place = 1.0, 2, min(x0, y0), max(x1, y1)
    for weight, size, low, high in (place, (VELOCITY_WEIGHT, 2, -top, top), (0.0, 1, 0.0, LONGEST)):
        part = base.RealVectorStateSpace(size)
        part.setBounds(low, high)
        space.addSubspace(part, weight)
    commands, bounds = control.RealVectorControlSpace(space, 3), base.RealVectorBounds(3)
    for axis, (low, high) in enumerate(((-top, top), (-top, top), (1.0, LONGEST_CONTROL + 1.0))):
        bounds.setLow(axis, low)
        bounds.setHigh(axis, high)
    commands.setBounds(bounds)
    setup = control.SimpleSetup(commands)

    def propagate(state: Any, command: Any, duration: float, result: Any) -> None:
        counted[0] += 1
        p, v, q, w = state[0], state[1], result[0], result[1]
        now = p[0], p[1], v[0], v[1]
        end, took = drive(clearance, source, constants, now, command[0], command[1], int(command[2]))
        q[0], q[1], w[0], w[1], _ = end
        result[2][0] = state[2][0] + took

    class Time(base.OptimizationObjective):
        def stateCost(self, state: Any) -> Any:  # noqa: N802  # OMPL's names
            return base.Cost(0.0)

        def motionCost(self, before: Any, after: Any) -> Any:  # noqa: N802
            return base.Cost(after[2][0] - before[2][0])

    class Disc(base.GoalRegion):
        def distanceGoal(self, state: Any) -> float:  # noqa: N802
            return math.hypot(state[0][0] - goal.x, state[0][1] - goal.y)

    drive(clearance, source, constants, (x0, y0, 0.0, 0.0), 0.0, 0.0, 1)  # compiled before the time counts
    setup.setStatePropagator(control.StatePropagatorFn(propagate))
    setup.setStateValidityChecker(base.StateValidityCheckerFn(lambda state: state[2][0] < LONGEST))
    begin = base.State(space)
    for k, value in enumerate((*np.asarray(world.start).tolist(), 0.0, 0.0, 0.0)):
        begin[k] = value
    setup.setStartState(begin)
    information = setup.getSpaceInformation()
    # how long a command holds is a part of it, so that Python is called once for each
    information.setMinMaxControlDuration(1, 1)
    information.setPropagationStepSize(1.0)
    disc = Disc(information)
    disc.setThreshold(goal.tolerance)
    setup.setGoal(disc)
    setup.setOptimizationObjective(Time(information))
    sst = control.SST(information)
    sst.setSelectionRadius(SELECTION)
    sst.setPruningRadius(PRUNING)
    setup.setPlanner(sst)
    return setup


def followed(found: Plan) -> Planner:
    """A planner that gives one plan, made beforehand from time 0: each cycle what is left of it."""

    def rest_of_it(
        memory: float | None, local_map: Any, state: State, goal: Any, settings: Any, deadline: Any = never
    ) -> tuple[Plan, float]:
        assert found.velocities is not None
        began = state.stamp if memory is None else memory
        since, samples = state.stamp - began, np.column_stack([found.positions, found.velocities])
        # two samples at its end, where the robot is late
        times = since + STEP * np.arange(max(2, math.ceil((found.times[-1] - since) / STEP) + 1))
        rows = np.column_stack([np.interp(times, found.times, each) for each in samples.T])
        return timed_path(state.stamp, began + times, rows[:, :2], rows[:, 2:]), began

    return Planner(rest_of_it, CONTROL_INTERVAL)
