"""The record of a trial, and how it comes together."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from collplan_core.command import Command
from collplan_core.evaluation.impact_matching import Prediction, judge_impacts
from collplan_core.evaluation.run_end import REACHED, path_length
from collplan_core.impact import Impact
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.state import State
from omnipuck_sim.robot.walks import Touch


@dataclass(frozen=True, eq=False)
class TrialResult:
    """The record of one run (simulated)."""

    world: str
    strategy: str
    seed: int
    outcome: str  # reached, timeout, stuck, or aborted where the planner gave the goal up
    reason: str  # of another outcome than reached
    arrival_time: float  # from the first non-zero command to the first pose within goal_tolerance, else the limit [s]
    path_length: float  # of the true path from the first non-zero command to the end [m]
    impacts: tuple[Impact, ...]  # all k of the run
    foreseen: np.ndarray  # (k,) whether a plan in force foresaw each
    deliberate: np.ndarray  # (k,) and whether it was deliberate too
    rebounds: np.ndarray
    """(k, 3) for each impact that the last plan before it foresaw, else NaN: angle between the direction of its rebound
    foreseen and the true one [rad], the speed foreseen and the true one [m/s]."""
    plan_times: np.ndarray  # (n,) wall time of each cycle from scan to plan [s]
    candidates: np.ndarray  # (n,) their number in each cycle
    candidates_before_pruning: np.ndarray  # (n,)
    maneuvers: dict[str, int]  # control periods spent in each
    commands: np.ndarray  # (c, 4) simulated time [s], velocity [m/s, body frame] and yaw rate [rad/s]
    trajectory: np.ndarray  # (m, 5) t, x, y, vx, vy of the truth at the mocap rate, t from the first non-zero command
    plans: tuple[np.ndarray, ...]  # the reference positions (n, 2) of each
    movers: np.ndarray  # (m, k, 5) x, y [m], vx, vy [m/s], radius [m] of each, at the times of the trajectory
    touches: tuple[Touch, ...]  # of movers, their times as in the trajectory

    @property
    def reached(self) -> bool:
        """Whether the robot reached its goal."""
        return self.outcome == REACHED

    def __repr__(self) -> str:
        """Summary in a line: outcome and impacts."""
        when = f"{self.outcome} in {self.arrival_time:.2f} s" if self.reached else f"{self.outcome}: {self.reason}"
        touches = f"{len(self.impacts)} impacts, {int(self.deliberate.sum())} deliberate"
        return f"TrialResult({self.world}, {self.strategy}, seed {self.seed}: {when}; {touches})"


class TrialRecord:
    """Record of a trial so far."""

    def __init__(self, world: str, settings: Settings, seed: int) -> None:
        """Starts empty."""
        self.impacts: list[Impact] = []  # the simulator's, as the touches of movers; may be added to
        self.touches: list[Touch] = []
        self._movers: list[np.ndarray] = []
        self._world, self._settings, self._seed = world, settings, seed
        self._begun: float | None = None
        self._rows: list[tuple[float, ...]] = []
        self._plans: list[Plan] = []
        self._plan_times: list[float] = []
        self._maneuvers: Counter[str] = Counter()
        self._commands: list[tuple[float, ...]] = []

    def planned(self, plan: Plan, planning_time: float) -> None:
        """Takes a plan, and the wall time in which it was made [s]."""
        self._plans.append(plan)
        self._plan_times.append(planning_time)

    def commanded(self, command: Command, now: float) -> None:
        """Takes a command given at `now` [s]; time counts from the first one that moves the robot."""
        self._maneuvers[command.maneuver] += 1
        self._commands.append((now, *command.velocity.tolist(), command.yaw_rate))
        if self._begun is None and command.velocity.any():
            self._begun = now

    def moved(self, truth: State, movers: np.ndarray) -> None:
        """Takes the true state of the robot, and of the movers (k, 5)."""
        if self._begun is not None:
            row = (truth.stamp - self._begun, *truth.position.tolist(), *truth.velocity.tolist())
            self._rows.append(row)
            self._movers.append(movers)

    def result(self, outcome: str, reason: str, arrived: float) -> TrialResult:
        """The record of the whole run, why it ended so, and the stamp of the pose with which it ended [s]."""
        trajectory = np.array(self._rows).reshape(-1, 5)
        predictions = [Prediction(plan.stamp, plan.contacts) for plan in self._plans]
        verdicts = judge_impacts(self.impacts, predictions)
        elapsed = 0.0 if self._begun is None else arrived - self._begun
        return TrialResult(
            world=self._world,
            strategy=self._settings.planner.strategy,
            seed=self._seed,
            outcome=outcome,
            reason=reason,
            arrival_time=elapsed if outcome == REACHED else self._settings.trial.timeout,
            path_length=path_length(trajectory[:, 1:3]) if len(trajectory) else 0.0,
            impacts=tuple(self.impacts),
            foreseen=verdicts.foreseen,
            deliberate=verdicts.deliberate,
            rebounds=verdicts.rebounds,
            plan_times=np.array(self._plan_times),
            candidates=np.array([len(plan.candidates.costs) for plan in self._plans], dtype=int),
            candidates_before_pruning=np.array([plan.n_before_pruning for plan in self._plans], dtype=int),
            maneuvers=dict(self._maneuvers),
            commands=np.array(self._commands).reshape(-1, 4),
            trajectory=trajectory,
            plans=tuple(plan.positions for plan in self._plans),
            movers=np.array(self._movers) if self._movers else np.zeros((0, 0, 5)),
            touches=tuple(touch._replace(time=touch.time - (self._begun or 0.0)) for touch in self.touches),
        )
