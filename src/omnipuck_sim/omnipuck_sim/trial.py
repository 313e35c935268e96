"""The closed loop without ROS: simulator, mocap filter, LIDAR, planner and controller, each at its own rate."""

import json
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from collplan_core.deadline import Deadline, after, never
from collplan_core.evaluation.run_end import OUTCOMES, REACHED, RunMonitor, drive_noise_hint
from collplan_core.goal import EXECUTING, Goal
from collplan_core.loop.closed_loop import ClosedLoop
from collplan_core.loop.decisions import Cycle, Decision
from collplan_core.loop.mover_guard import sight_hint
from collplan_core.movers.coverage import blind_angle
from collplan_core.parameters import Settings
from collplan_core.planners import first_memory, map_period_of
from collplan_core.poses import pose_filter
from collplan_core.poses.pose_filter import PoseSample
from collplan_core.replay.journal import CONTROLLER, PLANNER, Journal
from collplan_core.scan import Scan
from collplan_core.scans.filters import in_time
from collplan_core.state import State
from collplan_core.validation import check_type, finite
from collplan_core.worlds import World, WorldError, load_world, world_text
from collplan_core.worlds.instant_lidar import InstantLidar, MoverHistory
from collplan_core.worlds.spinning_lidar import Sweeps, sweeps_of
from omnipuck_sim.robot.noise import BURSTS, TOLERANCE, added_latency, faulty
from omnipuck_sim.robot.physics import Simulator
from omnipuck_sim.trial_record import TrialRecord, TrialResult


@dataclass(frozen=True)
class TrialJournals:
    """Journals of the inputs and decisions of a trial's loops."""

    planner: Journal
    controller: Journal


@contextmanager
def trial_journals(path: str | Path | None, world: World, settings: Settings, seed: int) -> Iterator[TrialJournals]:
    """Journals that are written to a file, which is replaced; without a path they keep nothing.

    OSError: the file cannot be written.
    """
    if path is None:
        yield TrialJournals(Journal(PLANNER), Journal(CONTROLLER))
        return
    with Path(path).open("w", encoding="utf-8") as file:

        def send(line: str) -> None:
            file.write(line + "\n")

        journals = TrialJournals(Journal(PLANNER, send), Journal(CONTROLLER, send))
        send(json.dumps({"trial": {"simulated": True, "world": world.name, "seed": seed}}))
        journals.planner.begin(settings, world_text(world) if settings.trial.known_map else None)
        journals.controller.begin(settings)
        try:
            yield journals
        finally:
            journals.planner.end_cycle()
            journals.controller.end_cycle()


PLANNER_PHASE = 0.01
"""After a scan the planner works on it so much later, as in the graph, where each node runs on its own timer [s]."""
CONTROLLER_PHASE = 0.025
"""The controller's ticks lie so much after the scans [s]."""


class TrialNodes:
    """The graph's nodes around one simulator, one method a node."""

    def __init__(
        self, world: World, settings: Settings, seed: int, goal: np.ndarray, solid: World, journals: TrialJournals
    ) -> None:
        self.settings, self.simulator = settings, Simulator(solid, settings, seed)
        self.record = TrialRecord(world.name, settings, seed)
        self._journals, self._filter_memory = journals, pose_filter.FRESH
        both = journals.planner, journals.controller
        self.loop = ClosedLoop(settings, self._hear, _deadline, first_memory(settings, world), both)
        self._monitor = RunMonitor(settings.trial, self.simulator.time)
        self._state: State | None = None
        self._scan: Scan | None = None
        self.measured: deque[PoseSample] = deque()
        self._last: PoseSample | None = None
        self._movers = MoverHistory()
        self._sweeps: Sweeps | None = sweeps_of(world, settings.lidar, seed, self._movers)
        self._instant = InstantLidar(world, settings.lidar, seed, self._movers)
        self._watch_movers()
        self.loop.take_goal(goal, self.simulator.time)

    def step(self, steps: int) -> None:
        """Advances time, and with it the sweep of a sensor that has one, from the robot's true pose."""
        if self._sweeps is None:
            self.simulator.step(steps)
            self._watch_movers()
            return
        for _ in range(steps):
            self.simulator.step()
            self._watch_movers()
            scan = self._sweeps.take_pose(self.simulator.state)
            if scan is not None:
                self._take_scan(scan)

    def _watch_movers(self) -> None:
        if self.simulator.movers.size:
            self._movers.add(self.simulator.time, self.simulator.movers[:, [0, 1, 4]])

    def measure(self) -> None:
        self._last = faulty(self.simulator.measured_pose(), self.settings.simulator.mocap_fault, self._last)
        self.measured.append(self._last)

    def filtered(self, sample: PoseSample) -> pose_filter.FilterResult:
        now = self.simulator.time
        settings = self.loop.controller.settings
        result, self._filter_memory = pose_filter.filter_pose(self._filter_memory, sample, now, settings)
        return result

    def mocap(self) -> None:
        simulation = self.settings.simulator
        if simulation.mocap_fault != BURSTS:
            self._take_sample(self.measured.popleft())
            return
        sent = self.simulator.time - simulation.mocap_latency + TOLERANCE
        while self.measured and self.measured[0].stamp <= sent:
            self._take_sample(self.measured.popleft())

    def _take_sample(self, sample: PoseSample) -> None:
        now, result = self.simulator.time, self.filtered(sample)
        if result.refused:
            self.loop.refuse_pose(result.refused)
        if result.kidnapped:
            self.loop.refuse_pose(pose_filter.KIDNAPPED)
        if result.state is not None:
            self._state = result.state
            impact = None if result.impact is None else (sample.stamp, result.impact.change)
            self.loop.take_pose(result.state, now, impact)

    def lidar(self) -> None:
        if self._state is not None and self._sweeps is None:
            self._take_scan(self._instant.scan(self._state))

    def planner(self) -> None:
        self.loop.plan(self.simulator.time)
        self._journals.planner.end_cycle()

    def controller(self) -> None:
        command = self.loop.tick(self.simulator.time)
        self.simulator.command(command.velocity, command.yaw_rate)
        self.record.commanded(command, self.simulator.time)
        self._monitor.commanded(command.maneuver)
        self._journals.controller.end_cycle()

    def outcome(self) -> str | None:
        """Returns how the run has ended; None while it goes on."""
        ended = OUTCOMES.get(self.loop.planner.goal.status)
        if ended or self._state is None:
            return ended
        return self._monitor.outcome(self._state.stamp, self._state.position)

    @property
    def reason(self) -> str:
        """Reason why the goal was given up, or why the run is over; and what the newest scan leaves out of view."""
        sight = "" if self._scan is None else sight_hint(blind_angle(self._scan), self.settings)
        said = filter(None, (self._monitor.reason, self.loop.planner.trouble, sight))
        return "; ".join(said) + drive_noise_hint(self.settings)

    @property
    def newest_stamp(self) -> float:
        """Stamp of the newest pose [s]."""
        return self.simulator.time if self._state is None else self._state.stamp

    def _take_scan(self, scan: Scan) -> None:
        self._scan = in_time(scan, self.settings.scan)
        self.loop.take_scan(self._scan, self.simulator.time)

    def _hear(self, decision: Decision, local: float) -> None:
        if isinstance(decision, Cycle):
            self.record.planned(decision.plan, self.loop.planning_time)
        elif isinstance(decision, Goal) and decision.status == EXECUTING:
            self._monitor.executing(local)


def _deadline(settings: Settings) -> Deadline:
    budget = settings.time_to_goal.time_budget
    return after(budget) if budget > 0.0 else never


class _Timer:
    """Ticks at a rate [Hz], the first one after `phase` [s], counted in physics steps; `next` is the next one."""

    def __init__(self, rate: float, physics_rate: float, phase: float = 0.0) -> None:
        self._rate, self._physics_rate, self._phase = rate, physics_rate, phase
        self._ticks = 0
        self.next = self._step_of(0)

    def _step_of(self, tick: int) -> int:
        return round((tick / self._rate + self._phase) * self._physics_rate)

    def due(self, step: int) -> bool:
        """Returns whether a tick falls on this step; true once for each."""
        if step < self.next:
            return False
        self._ticks += 1
        self.next = self._step_of(self._ticks)
        return True


def run_trial(
    world: World | str | Path,
    settings: Settings,
    seed: int,
    goal: ArrayLike | None = None,
    solid: World | None = None,
    journal: str | Path | None = None,
    nodes_class: type[TrialNodes] = TrialNodes,
) -> TrialResult:
    """Runs one trial from the world's start to the goal, the world's own by default.

    Args:
        world: the world, or what `load_world` takes.
        solid: world of the robot's contacts, where it differs from the one that the LIDAR sees.
        journal: file for the inputs and decisions of planner and controller; `replay` reads it.
        nodes_class: the nodes, for studies in which one of them is another.

    Raises:
        WorldError: the world is unknown, has no start or no goal, or the start has no room for the robot.
        TypeError, ValueError: another argument is of another type, shape or range.
        ParameterError: `trial.known_map` is true for a planner that cannot hold a map.
        OSError: the journal cannot be written.
    """
    world = world if isinstance(world, World) else load_world(world)
    solid = world if solid is None else solid
    check_type("settings", settings, Settings, ", as in Settings()")
    if not (isinstance(seed, int | np.integer) and seed >= 0):
        raise ValueError(f"seed: got {seed!r:.80}, expected a whole number from 0")
    goal = world.goal if goal is None else goal
    if goal is None:
        raise WorldError(f"{world.called}: goal: missing, expected x, y")
    aim = finite("goal", goal, (2,), "expected x, y [m]")
    with trial_journals(journal, world, settings, seed) as journals:
        nodes = nodes_class(world, settings, seed, aim, solid, journals)
        outcome = _run(nodes)
        return nodes.record.result(outcome, "" if outcome == REACHED else nodes.reason, nodes.newest_stamp)


def _run(nodes: TrialNodes) -> str:
    """Runs to the end; returns the outcome."""
    settings, simulator, record = nodes.settings, nodes.simulator, nodes.record
    rate = settings.simulator.physics_rate
    measuring, lidar = _Timer(settings.simulator.mocap_rate, rate), _Timer(settings.lidar.rate, rate)
    latency = settings.simulator.mocap_latency + added_latency(settings.simulator.mocap_fault, 0.0)
    mocap = _Timer(settings.simulator.mocap_rate, rate, latency)
    planner = _Timer(1.0 / map_period_of(settings.planner), rate, PLANNER_PHASE)
    controller = _Timer(settings.controller.rate, rate, CONTROLLER_PHASE)
    timers = (measuring, mocap, lidar, planner, controller)
    step = 0
    while True:
        measures = measuring.due(step)
        if measures:
            nodes.measure()
        if mocap.due(step):
            nodes.mocap()
        if measures:
            record.moved(simulator.state, simulator.movers)
            outcome = nodes.outcome()
            if outcome:
                return outcome
        if lidar.due(step):
            nodes.lidar()
        if planner.due(step):
            nodes.planner()
        if controller.due(step):
            nodes.controller()
        wake = min(timer.next for timer in timers)
        nodes.step(wake - step)
        record.impacts += simulator.take_impacts()
        record.touches += simulator.take_touches()
        step = wake
