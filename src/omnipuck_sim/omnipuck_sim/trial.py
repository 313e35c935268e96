"""The closed loop without ROS: simulator, mocap filter, LIDAR, planner and controller, each at its own rate.

`run_trial` is one call and returns a plain record. Equal arguments give equal records bit by bit, wall times aside.
"""

from collections import Counter
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from collplan_core.command import stopped
from collplan_core.control.memory import ControllerMemory
from collplan_core.deadline import Deadline, after, never
from collplan_core.evaluation.impact_matching import Prediction, foreseen_impacts, foreseen_rebounds
from collplan_core.evaluation.path_length import path_length
from collplan_core.local_map import LocalMap, build_local_map
from collplan_core.parameters import Settings
from collplan_core.plan import NoPlan, Plan
from collplan_core.planners import map_period_of, planner_for
from collplan_core.scan import Scan, ScanError
from collplan_core.sensing import pose_filter
from collplan_core.sensing.pose_history import PoseHistory
from collplan_core.state import State
from collplan_core.time_to_goal_planner.known_map import given_map
from collplan_core.worlds import World, WorldError
from collplan_core.worlds.raycast import simulate_scan
from omnipuck_sim.robot.physics import Simulator
from omnipuck_sim.robot.rebound import Impact

PLANNER_PHASE = 0.01
"""After a scan the planner works on it so much later, as in the graph, where each node runs on its own timer [s]."""
CONTROLLER_PHASE = 0.025
"""The controller's ticks lie so much after the scans [s]."""

REACHED, TIMEOUT, STUCK = "reached", "timeout", "stuck"


@dataclass(frozen=True, eq=False)
class TrialResult:
    """The record of one run (simulated).

    Attributes:
        outcome: reached, timeout or stuck.
        arrival_time: from the first non-zero command to the first pose within goal_tolerance, else the limit [s].
        path_length: length of the true path from the first non-zero command to the end [m].
        impacts: all k impacts of the run; foreseen: (k,) whether a plan in force foresaw each.
        rebounds: (k, 3) for each impact that the last plan before it foresaw, else NaN: angle between the foreseen
            direction of its rebound and the true one [rad], the speed foreseen and the true one [m/s].
        plan_times: (n,) wall time of each cycle from scan to plan [s].
        candidates, candidates_before_pruning: (n,) numbers of candidates in each cycle.
        maneuvers: control periods spent in each maneuver.
        trajectory: (m, 5) t, x, y, vx, vy of the truth at the mocap rate, t from the first non-zero command.
        plans: the reference positions (n, 2) of every plan.
    """

    world: str
    strategy: str
    seed: int
    outcome: str
    arrival_time: float
    path_length: float
    impacts: tuple[Impact, ...]
    foreseen: np.ndarray
    rebounds: np.ndarray
    plan_times: np.ndarray
    candidates: np.ndarray
    candidates_before_pruning: np.ndarray
    maneuvers: dict[str, int]
    trajectory: np.ndarray
    plans: tuple[np.ndarray, ...]


class _Loop:
    """The nodes' state between their calls, one method a node."""

    def __init__(self, world: World, settings: Settings, seed: int, goal: np.ndarray) -> None:
        self.world, self.settings, self.goal = world, settings, goal
        self.simulator = Simulator(world, settings, seed)
        self._planner = planner_for(settings.planner.strategy)
        self.filter_memory = pose_filter.FRESH
        self.history = PoseHistory(settings.limits.pose_history)
        self.planner_memory: Any = given_map(world, settings) if settings.trial.known_map else None
        self.controller_memory = ControllerMemory()
        self.state: State | None = None
        self.scan: Scan | None = None
        self.plan: Plan | None = None
        self.plan_map: LocalMap | None = None
        self.command = stopped("no plan yet")
        self.impacts: list[Impact] = []
        self.predictions: list[Prediction] = []
        self.plans: list[np.ndarray] = []
        self.plan_times: list[float] = []
        self.counts: list[tuple[int, int]] = []
        self.maneuvers: Counter[str] = Counter()

    def mocap(self) -> None:
        sample = self.simulator.measured_pose()
        result, self.filter_memory = pose_filter.filter_pose(
            self.filter_memory, sample, self.simulator.time, self.settings
        )
        if result.state is not None:
            self.state = result.state
            self.history.add(result.state)
        if result.impact is not None and self._planner.replans_after_impact:
            self.planner()

    def lidar(self) -> None:
        if self.state is not None:
            self.scan = simulate_scan(self.world, self.state, self.settings.lidar)

    def planner(self) -> None:
        if self.scan is None or self.state is None:
            return
        at_scan = self.history.at(self.scan.stamp)
        if at_scan is None:
            return
        begun = perf_counter()
        try:
            local_map = build_local_map(self.scan, at_scan, self.settings.robot, self.settings.local_map)
            initial = self.state if self._planner.starts_at_newest_pose else at_scan
            plan, self.planner_memory = self._planner.plan(
                self.planner_memory, local_map, initial, self.goal, self.settings, self._deadline(begun)
            )
        except ScanError:
            return
        except NoPlan as error:
            self.planner_memory = error.memory or self.planner_memory
            return
        self.plan_times.append(perf_counter() - begun)
        self.plan, self.plan_map = plan, local_map
        self.plans.append(plan.positions)
        self.predictions.append(Prediction(plan.stamp, plan.contacts))
        self.counts.append((len(plan.candidates.costs), plan.n_before_pruning))

    def _deadline(self, begun: float) -> Deadline:
        budget = self.settings.time_to_goal.time_budget
        return after(begun, budget) if budget > 0.0 else never

    def controller(self) -> None:
        now = self.simulator.time
        fresh = self.plan is not None and now - self.plan.stamp <= 2 * map_period_of(self.settings) + 0.2
        if self.plan is None or self.plan_map is None or self.state is None or not fresh:
            self.command = stopped("no fresh plan")
        else:
            self.command, self.controller_memory = self._planner.follow(
                self.controller_memory, self.plan, self.plan_map, self.state, now, self.settings
            )
        self.simulator.command(self.command.velocity, self.command.yaw_rate)
        self.maneuvers[self.command.maneuver] += 1

    @property
    def moving(self) -> bool:
        """Whether a non-zero command is out."""
        return bool(self.command.velocity.any())


class _Timer:
    """Ticks at a rate [Hz], the first one after `phase` [s], counted in physics steps; `next` is the next one."""

    def __init__(self, rate: float, physics_rate: float, phase: float = 0.0) -> None:
        self._rate, self._physics_rate, self._phase = rate, physics_rate, phase
        self._ticks = 0
        self.next = self._step_of(0)

    def _step_of(self, tick: int) -> int:
        return round((tick / self._rate + self._phase) * self._physics_rate)

    def due(self, step: int) -> bool:
        """Whether a tick falls on this step; true once for each."""
        if step < self.next:
            return False
        self._ticks += 1
        self.next = self._step_of(self._ticks)
        return True


def run_trial(world: World, settings: Settings, seed: int, goal: np.ndarray | None = None) -> TrialResult:
    """One run from the world's start to the goal, the world's own by default.

    Raises:
        WorldError: the world has no start or no goal, or the start is inside an obstacle.
    """
    goal = world.goal if goal is None else goal
    if goal is None:
        raise WorldError(f"{world.name}: goal: missing, expected x, y")
    loop = _Loop(world, settings, seed, np.asarray(goal, dtype=float))
    outcome, begun, rows = _run(loop)
    return _result(loop, seed, outcome, begun, np.array(rows).reshape(-1, 5))


def _run(loop: _Loop) -> tuple[str, float, list[tuple[float, ...]]]:
    """Runs to the end: the outcome, the time of the first non-zero command, the true states since then."""
    settings, simulator = loop.settings, loop.simulator
    rate = settings.simulator.physics_rate
    mocap, lidar = _Timer(settings.simulator.mocap_rate, rate), _Timer(settings.lidar.rate, rate)
    planner = _Timer(1.0 / map_period_of(settings), rate, PLANNER_PHASE)
    controller = _Timer(settings.controller.rate, rate, CONTROLLER_PHASE)
    timers = (mocap, lidar, planner, controller)
    begun: float | None = None
    rows: list[tuple[float, ...]] = []
    step = 0
    while True:
        if mocap.due(step):
            loop.mocap()
            truth = simulator.state
            if begun is not None:
                rows.append((truth.stamp - begun, *truth.position.tolist(), *truth.velocity.tolist()))
            if (
                loop.state is not None
                and np.hypot(*(loop.state.position - loop.goal)) <= settings.planner.goal_tolerance
            ):
                return REACHED, simulator.time if begun is None else begun, rows
            if begun is not None and rows[-1][0] >= settings.trial.timeout:
                return TIMEOUT, begun, rows
            if _is_stuck(rows, settings):
                return STUCK, begun or 0.0, rows
            if begun is None and simulator.time >= settings.trial.timeout:
                return STUCK, simulator.time, rows
        if lidar.due(step):
            loop.lidar()
        if planner.due(step):
            loop.planner()
        if controller.due(step):
            loop.controller()
            begun = simulator.time if begun is None and loop.moving else begun
        wake = min(timer.next for timer in timers)
        for _ in range(wake - step):
            simulator.step()
        loop.impacts += simulator.take_impacts()
        step = wake


def _is_stuck(rows: list[tuple[float, ...]], settings: Settings) -> bool:
    """Whether the last stuck_time brought less than stuck_distance, seen from where it began."""
    n = round(settings.trial.stuck_time * settings.simulator.mocap_rate)
    if len(rows) <= n or len(rows) % 10:
        return False
    recent = np.array(rows[-n:])[:, 1:3]
    return bool(np.hypot(*(recent - recent[0]).T).max() < settings.trial.stuck_distance)


def _result(loop: _Loop, seed: int, outcome: str, begun: float, trajectory: np.ndarray) -> TrialResult:
    times = np.array([impact.time for impact in loop.impacts])
    points = np.array([impact.point for impact in loop.impacts]).reshape(-1, 2)
    after = np.array([impact.velocity_after for impact in loop.impacts]).reshape(-1, 2)
    counts = np.array(loop.counts, dtype=int).reshape(-1, 2)
    elapsed = trajectory[-1, 0] if len(trajectory) else 0.0
    return TrialResult(
        world=loop.world.name,
        strategy=loop.settings.planner.strategy,
        seed=seed,
        outcome=outcome,
        arrival_time=float(elapsed) if outcome == REACHED else loop.settings.trial.timeout,
        path_length=path_length(trajectory[:, 1:3]) if len(trajectory) else 0.0,
        impacts=tuple(loop.impacts),
        foreseen=foreseen_impacts(times, points, loop.predictions),
        rebounds=foreseen_rebounds(times, points, after, loop.predictions),
        plan_times=np.array(loop.plan_times),
        candidates=counts[:, 0],
        candidates_before_pruning=counts[:, 1],
        maneuvers=dict(loop.maneuvers),
        trajectory=trajectory,
        plans=tuple(loop.plans),
    )
