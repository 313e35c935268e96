"""The time to the goal as the objective: reading `plan_cycle` top to bottom is reading how it is minimised.

Memory of boundaries, shortest paths over it, coarse plans of two velocities, the best of them and the last plan carried
to the goal, refinement. The strategies differ in the terms for contacts alone.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from collplan_core.deadline import Deadline, never
from collplan_core.local_map.record import LocalMap
from collplan_core.parameters import Mocap, Settings, TimeToGoal
from collplan_core.plan import Candidates, Contacts, NoPlan, Plan
from collplan_core.state import State
from collplan_core.time_to_goal_planner.arrival import UNSTOPPABLE
from collplan_core.time_to_goal_planner.boundary_memory.clearance import OBSERVED
from collplan_core.time_to_goal_planner.boundary_memory.update import remember
from collplan_core.time_to_goal_planner.boundary_memory.working import RememberedBoundaries
from collplan_core.time_to_goal_planner.dynamics import Motion, motion_at
from collplan_core.time_to_goal_planner.full_plan import FullPlan, braking, roll, sample_trajectory
from collplan_core.time_to_goal_planner.initial_plans import (
    MARGIN,
    CoarsePlans,
    best_coarse,
    coarse_commands,
    coarse_plans,
    extended,
    padded,
    shifted,
    targets,
    tracked,
)
from collplan_core.time_to_goal_planner.initial_state import Expected, initial_velocity
from collplan_core.time_to_goal_planner.model import CONTROL_INTERVAL, STEP, Problem, problem_of
from collplan_core.time_to_goal_planner.mover_cost import discs_and_trails
from collplan_core.time_to_goal_planner.refinement import refine
from collplan_core.time_to_goal_planner.shortest_paths.record import ShortestPaths
from collplan_core.time_to_goal_planner.shortest_paths.search import shortest_paths
from collplan_core.time_to_goal_planner.smoothing.smooth import smoothed
from collplan_core.time_to_goal_planner.tried_gaps import TriedGaps, with_try
from collplan_core.time_to_goal_planner.way_to_goal import way_to_goal

TURNS = 2
"""One in so many velocities is tried in a cycle's coarse plans with a plan in force; the next cycle tries others."""
HORIZON = 1.3
"""Length of a coarse rollout [s]."""
LONGEST_PLAN = 8.0
"""Longest plan; if it has not arrived by then, the time to go from its end is added to its cost [s]."""
N_STARTS = 5
"""Coarse plans that are extended to the goal and refined, beside the last plan."""
START_PROPOSALS = 50
"""Most changes tried on each coarse plan that is refined."""
CHUNK = 200
"""Changes tried between two looks at the deadline, and at what they gained."""
SMOOTHED = 2
"""Plans that are smoothed, of those that a few changes made best; the best of all is smoothed again at the end."""
SETTLED = 5e-4
"""Refinement of a plan ends when the last CHUNK of changes gained less than this [s]."""


@dataclass(frozen=True, eq=False)
class RolloutMemory:
    """Memory that one planning cycle leaves to the next."""

    remembered: RememberedBoundaries | None = None  # boundaries seen so far
    map_stamp: float = -np.inf  # stamp of the last scan in them [s]
    known: bool = False  # whether the whole map was given, to which nothing is added
    paths: ShortestPaths | None = None  # shortest paths to the goal
    plan_stamp: float = 0.0  # stamp at which the plan in force begins [s]
    commands: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    """(n, 2) commands of the plan in force, one a control interval [m/s]."""
    expected: Expected | None = None  # states and contacts that the plan in force foresees
    tried: TriedGaps = field(default_factory=TriedGaps)  # gaps too narrow for the disc that were tried
    cycle: int = 0  # number of cycles so far, the seed of the refinement

    def without_plan(self) -> "RolloutMemory":
        """Returns the memory without a plan in force."""
        return replace(self, commands=np.zeros((0, 2)), expected=None)


def plan_cycle(
    memory: RolloutMemory | None,
    local_map: LocalMap,
    state: State,
    goal: np.ndarray,
    settings: Settings,
    deadline: Deadline = never,
) -> tuple[Plan, RolloutMemory]:
    """One cycle: from a local map to a timed reference to the goal (2,) [m], with the contacts it foresees.

    Args:
        memory: memory of the previous cycle, None at the start and after a new goal.
        state: the newest one; it may be younger than the map.
        deadline: of refinement, which ends with the best plan so far.

    Raises:
        NoPlan: seen boundaries close off the goal.
    """
    memory = _updated(memory or RolloutMemory(), local_map, state, np.array(goal, dtype=float), settings)
    assert memory.remembered is not None
    assert memory.paths is not None
    way = way_to_goal(memory.remembered, memory.paths, state.position, settings, memory.tried)
    gap = None if way is None else way.gap
    tried = with_try(memory.tried, gap, state.position, state.stamp, settings.robot.radius)
    memory = replace(memory, tried=tried)
    if way is None:
        raise NoPlan(f"the goal {goal[0]:.3f}, {goal[1]:.3f} is closed off by boundaries seen so far", memory)
    remembered, paths, _ = way
    movers = discs_and_trails(local_map, state.stamp, settings)
    problem = problem_of(remembered.field, remembered.free, paths, settings, state.yaw, movers)
    initial = _initial_motion(problem, state, memory.expected, settings.mocap)
    carried_on = _carried_on(problem, initial, memory, state.stamp)
    best_so_far = min((plan.cost for plan in carried_on), default=np.inf)
    velocities = targets(problem, initial)
    if carried_on:
        velocities = velocities[memory.cycle % TURNS :: TURNS].copy()
    n_steps = round(HORIZON / STEP)
    coarse = coarse_plans(problem, initial, velocities, n_steps, best_so_far, MARGIN)
    plans = carried_on + _from_coarse(problem, initial, coarse)
    if not plans:  # no path leads on from anywhere around
        plans = [braking(problem, initial)]
    compared = _compared(coarse, plans)
    best = _refined(problem, plans, np.random.default_rng(memory.cycle), deadline, settings.time_to_goal)
    if problem.stop_test and best.costs[best.n] >= UNSTOPPABLE:
        best = braking(problem, initial)
    rows, contacts = sample_trajectory(problem, initial, best.commands[: max(best.n, 1)], settings.robot.radius)
    contacts = contacts[contacts[:, 8] == OBSERVED]
    plan = _plan(state.stamp, rows, contacts, best, compared, coarse.costs.size)
    expected = Expected(plan.times, plan.positions, rows[:, 3:], plan.contacts.times)
    commands = best.commands[: best.n].copy()
    return plan, replace(memory, plan_stamp=state.stamp, commands=commands, expected=expected)


def _updated(
    memory: RolloutMemory, local_map: LocalMap, state: State, goal: np.ndarray, settings: Settings
) -> RolloutMemory:
    """The memory with the newest scan and the shortest paths over it."""
    remembered = memory.remembered
    if remembered is None or (local_map.stamp > memory.map_stamp and not memory.known):
        remembered = remember(remembered, local_map, settings.robot, settings.remembered)
    paths = shortest_paths(remembered.field, goal, state.position, settings, memory.paths)
    return replace(memory, remembered=remembered, paths=paths, map_stamp=local_map.stamp, cycle=memory.cycle + 1)


def _initial_motion(problem: Problem, state: State, expected: Expected | None, mocap: Mocap) -> Motion:
    x, y, vx, vy = (float(value) for value in (*state.position, *initial_velocity(state, expected, mocap)))
    return motion_at(problem.clearance, problem.constants.grid, x, y, vx, vy)


def _carried_on(problem: Problem, initial: Motion, memory: RolloutMemory, stamp: float) -> list[FullPlan]:
    """Returns the rest of the last plan, as it is and led back to its path; empty where there is none."""
    size = round(LONGEST_PLAN / CONTROL_INTERVAL)
    left = shifted(memory.commands, stamp - memory.plan_stamp)[:size]
    if not len(left) or memory.expected is None:
        return []
    path = memory.expected.positions_at(stamp + CONTROL_INTERVAL * np.arange(len(left)))
    led_back = tracked(problem, initial, left, path)
    return [roll(problem, initial, padded(each, size), len(left)) for each in (left, led_back)]


def _from_coarse(problem: Problem, initial: Motion, coarse: CoarsePlans) -> list[FullPlan]:
    """The best coarse plans, carried on to the goal."""
    size, n_steps = round(LONGEST_PLAN / CONTROL_INTERVAL), round(HORIZON / STEP)
    places = best_coarse(coarse.costs, N_STARTS)
    return [extended(problem, initial, *coarse_commands(coarse, place, n_steps, size)) for place in places]


def _compared(coarse: CoarsePlans, plans: list[FullPlan]) -> Candidates:
    """Returns the candidates: ends of the coarse plans, and the plans to be refined, before their refinement."""
    rolled = np.isfinite(coarse.costs)
    ends = coarse.ends[rolled]
    return Candidates(
        positions=ends[:, :2],
        velocities=ends[:, 2:],
        costs=coarse.costs[rolled],
        paths=tuple(each.states[: each.n + 1, :2].copy() for each in plans),
        path_costs=tuple(each.cost for each in plans),
    )


def _refined(
    problem: Problem, plans: list[FullPlan], random: np.random.Generator, deadline: Deadline, time_to_goal: TimeToGoal
) -> FullPlan:
    """The best of the plans, refined: some changes on each, the best few made smooth, and more changes on the best."""
    few, many = min(START_PROPOSALS, time_to_goal.proposals), time_to_goal.proposals

    def refined(plan: FullPlan, count: int) -> FullPlan:
        gained = np.inf
        while count > 0 and gained > SETTLED and not deadline():
            better = refine(problem, plan, min(count, CHUNK), random)
            plan, count, gained = better, count - CHUNK, plan.cost - better.cost
        return plan

    def smoother(plan: FullPlan) -> FullPlan:
        if deadline():
            return plan
        return min(plan, refined(smoothed(problem, plan), many // 3), key=_cost)

    tried = sorted((refined(plan, few) for plan in sorted(plans, key=_cost)), key=_cost)
    best = min((smoother(plan) for plan in tried[:SMOOTHED]), key=_cost)
    return smoother(refined(best, many))


def _cost(plan: FullPlan) -> float:
    """Returns the cost by which plans are compared [s]."""
    return plan.cost


def contacts_of(stamp: float, rows: np.ndarray) -> Contacts:
    """Contacts of a trajectory that begins at `stamp` [s], from rows of `sample_trajectory`."""
    return Contacts(stamp + rows[:, 0], rows[:, 1:3], rows[:, 3:5], rows[:, 5:7], rows[:, 7])


def _plan(
    stamp: float,
    rows: np.ndarray,
    contacts: np.ndarray,
    best: FullPlan,
    compared: Candidates,
    n_before_pruning: int,
) -> Plan:
    """The plan as a record, from a trajectory's rows and contacts; its times count from `stamp` [s]."""
    times, positions, velocities = (
        np.ascontiguousarray(columns) for columns in (stamp + rows[:, 0], rows[:, 1:3], rows[:, 3:])
    )
    paid = float(best.costs[best.n])
    return Plan(
        stamp=stamp,
        times=times,
        positions=positions,
        velocities=velocities,
        contacts=contacts_of(stamp, contacts),
        aim=positions[-1],
        aim_velocity=velocities[-1],
        terms={"total": best.cost, "arrival_time": best.cost - paid, "contact_and_clearance": paid},
        candidates=compared,
        n_before_pruning=n_before_pruning,
    )
