"""The time to the goal as the objective: reading `plan_cycle` top to bottom is reading how it is minimised.

Memory of boundaries, shortest paths over it, coarse plans of two velocities, the best of them and the last plan carried
to the goal, refinement. The strategies differ in the terms for contacts alone.
"""

from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np

from collplan_core.local_map.record import LocalMap
from collplan_core.parameters import Settings
from collplan_core.plan import Candidates, Contacts, NoPlan, Plan
from collplan_core.state import State
from collplan_core.strategies import contact_terms
from collplan_core.time_to_goal_planner.boundary_memory.record import RememberedBoundaries
from collplan_core.time_to_goal_planner.boundary_memory.update import remember
from collplan_core.time_to_goal_planner.coarse_search import SWITCH_STEPS, coarse_plans
from collplan_core.time_to_goal_planner.full_plan import extend, near_at, roll
from collplan_core.time_to_goal_planner.initial_plans import best_coarse, coarse_commands, padded, shifted, tracked
from collplan_core.time_to_goal_planner.initial_state import Expected, begin_velocity
from collplan_core.time_to_goal_planner.model import KNOT, STEP, Law, Price, Scene, law_of, price_of, scene_of
from collplan_core.time_to_goal_planner.refinement import refine
from collplan_core.time_to_goal_planner.sampling import in_full
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import is_reachable
from collplan_core.time_to_goal_planner.shortest_paths.record import ShortestPaths
from collplan_core.time_to_goal_planner.shortest_paths.search import shortest_paths
from collplan_core.time_to_goal_planner.stopping import UNSTOPPABLE

TRACKING = 2.5
"""Gain with which the plan in force is tracked, where its own commands led beside it [1/s]."""
CHUNK = 100
"""Changes tried between two looks at the clock."""


@dataclass(frozen=True, eq=False)
class RolloutMemory:
    """What one cycle leaves to the next.

    Attributes:
        remembered: boundaries; map_stamp: of the last scan in them [s].
        known: whether the whole map was given: nothing is added.
        paths: shortest paths.
        begun: when the plan in force begins [s]; commands: (n, 2) its commands, one a knot [m/s].
        expected: what it foresees.
        rollouts: the best coarse plans (k, 2) [m], for display.
        cycle: how many there were: the seed of the refinement.
    """

    remembered: RememberedBoundaries | None = None
    map_stamp: float = -np.inf
    known: bool = False
    paths: ShortestPaths | None = None
    begun: float = 0.0
    commands: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    expected: Expected | None = None
    rollouts: tuple[np.ndarray, ...] = ()
    cycle: int = 0


@dataclass(frozen=True, eq=False)
class _Whole:
    """A whole plan while it is worked on; the arrays are longer than n."""

    commands: np.ndarray
    states: np.ndarray
    costs: np.ndarray
    n: int
    j: float


def plan_cycle(memory: RolloutMemory | None, local_map: LocalMap, state: State, goal: np.ndarray,
                 settings: Settings) -> tuple[Plan, RolloutMemory]:  # fmt: skip
    """One cycle: from a local map to a timed reference to the goal, with the contacts it foresees.

    Args:
        memory: what the previous cycle left, None at the start and after a new goal.
        state: the newest one; it may be younger than the map.
        goal: (2,) [m].

    Raises:
        NoPlan: what is remembered closes off the goal.
    """
    begun = perf_counter()
    memory = _updated(memory or RolloutMemory(), local_map, state, np.array(goal, dtype=float), settings)
    assert memory.remembered is not None
    assert memory.paths is not None
    if not is_reachable(memory.paths, state.position):
        raise NoPlan(f"the goal {goal[0]:.3f}, {goal[1]:.3f} is closed off by boundaries seen so far", memory)
    scene = scene_of(memory.remembered.field, memory.remembered.free, memory.paths, settings)
    law, price = law_of(settings), price_of(settings)
    begin = np.array([*state.position, *begin_velocity(state, memory.expected, settings)])
    coarse, starts = _starts(memory, scene, law, price, begin, state.stamp, settings)
    rollouts = tuple(start.states[: start.n + 1, :2].copy() for start in starts)
    whole = _refined(starts, scene, law, price, memory.cycle, begun, settings)
    if whole.costs[whole.n] >= UNSTOPPABLE and contact_terms(settings).stop_test:
        whole = _braking(scene, law, price, begin, settings)
    return _finished(replace(memory, rollouts=rollouts), coarse, whole, scene, law, begin, state, settings)


def _updated(memory: RolloutMemory, local_map: LocalMap, state: State, goal: np.ndarray, settings: Settings,
             ) -> RolloutMemory:  # fmt: skip
    """With the newest scan and the shortest paths over it."""
    remembered = memory.remembered
    if remembered is None or (local_map.stamp > memory.map_stamp and not memory.known):
        remembered = remember(remembered, local_map, settings.robot, settings.remembered)
    paths = shortest_paths(remembered.field, goal, state.position, settings, memory.paths)
    return replace(memory, remembered=remembered, paths=paths, map_stamp=local_map.stamp, cycle=memory.cycle + 1)


def _starts(memory: RolloutMemory, scene: Scene, law: Law, price: Price, begin: np.ndarray, stamp: float,
            settings: Settings) -> tuple[Candidates, list[_Whole]]:  # fmt: skip
    """The coarse plans, and the whole plans to refine: the last one carried on, and the best coarse ones extended."""
    p, test = settings.time_to_goal, contact_terms(settings).stop_test
    most = round(p.longest_plan / KNOT)
    first = np.array([*begin, near_at(scene, begin[0], begin[1]), 0.0])
    velocities, j, ends = coarse_plans(scene, law, price, first, round(p.horizon / STEP), test)
    starts = []
    last = shifted(memory.commands, stamp - memory.begun)
    if len(last) and memory.expected is not None:
        back = tracked(
            scene, law, price, begin, last, memory.expected.positions_at(stamp + KNOT * np.arange(len(last))), TRACKING
        )
        starts += [
            _rolled(scene, law, price, test, begin, padded(each, most), len(last), most) for each in (last, back)
        ]
    for a, b, c in best_coarse(j, p.n_starts):
        commands = np.zeros((most, 2))
        n = coarse_commands(commands, velocities[a], velocities[c], SWITCH_STEPS[b], round(p.horizon / STEP))
        rolled = _rolled(scene, law, price, test, begin, commands, n, most)
        if rolled.n == n:
            n = extend(scene, law, price, commands, n, rolled.states[n])
            rolled = _rolled(scene, law, price, test, begin, commands, n, most)
        starts.append(rolled)
    return Candidates(ends[..., :2].reshape(-1, 2), ends[..., 2:].reshape(-1, 2), j.reshape(-1)), starts


def _rolled(scene: Scene, law: Law, price: Price, test: bool, begin: np.ndarray, commands: np.ndarray, n: int,
            most: int) -> _Whole:  # fmt: skip
    states, costs = np.zeros((most + 1, 4)), np.zeros(most + 1)
    states[0] = begin
    used, j, _ = roll(scene, law, price, test, commands, n, states, costs)
    return _Whole(commands, states, costs, used, j)


def _refined(starts: list[_Whole], scene: Scene, law: Law, price: Price, seed: int, begun: float,
             settings: Settings) -> _Whole:  # fmt: skip
    """The best of the starts, refined: some changes on each, more on the best."""
    p, test = settings.time_to_goal, contact_terms(settings).stop_test
    until = begun + p.time_budget if p.time_budget > 0.0 else np.inf

    def refined(whole: _Whole, count: int) -> _Whole:
        while count > 0 and perf_counter() < until:
            n, j, _ = refine(
                scene, law, price, test, random, min(count, CHUNK), whole.commands, whole.states, whole.costs, whole.n,
                whole.j,
            )  # fmt: skip
            whole, count = replace(whole, n=n, j=j), count - CHUNK
        return whole

    random = np.random.default_rng(seed)
    starts = sorted(starts, key=lambda whole: whole.j)
    return refined(min((refined(whole, p.start_proposals) for whole in starts), key=lambda whole: whole.j), p.proposals)


def _braking(scene: Scene, law: Law, price: Price, begin: np.ndarray, settings: Settings) -> _Whole:
    """Rest is commanded: no plan passed the stop test."""
    n = round(2.0 * law.max_speed / law.max_acceleration / KNOT) + 1
    return _rolled(scene, law, price, False, begin, np.zeros((n, 2)), n, n)


def _finished(memory: RolloutMemory, coarse: Candidates, whole: _Whole, scene: Scene, law: Law, begin: np.ndarray,
              state: State, settings: Settings) -> tuple[Plan, RolloutMemory]:  # fmt: skip
    rows, hits = in_full(scene, law, begin, whole.commands, max(whole.n, 1), settings.robot.radius)
    times, positions, velocities = (
        np.ascontiguousarray(columns) for columns in (state.stamp + rows[:, 0], rows[:, 1:3], rows[:, 3:])
    )
    contacts = Contacts(state.stamp + hits[:, 0], hits[:, 1:3], hits[:, 3:])
    paid = float(whole.costs[whole.n])
    plan = Plan(
        stamp=state.stamp, times=times, positions=positions, velocities=velocities, contacts=contacts,
        aim=positions[-1], aim_velocity=velocities[-1],
        terms={"total": whole.j, "arrival_time": whole.j - paid, "contact_and_clearance": paid},
        candidates=coarse, n_before_pruning=len(coarse.costs),
    )  # fmt: skip
    expected = Expected(times, positions, velocities, contacts.times)
    commands = whole.commands[: whole.n].copy()
    return plan, replace(memory, begun=state.stamp, commands=commands, expected=expected)
