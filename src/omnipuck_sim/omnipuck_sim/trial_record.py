"""The record of a trial, and how it comes together."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from collplan_core.command import Command
from collplan_core.evaluation.impact_matching import Prediction
from collplan_core.evaluation.run_end import REACHED
from collplan_core.evaluation.run_record import RunRecord
from collplan_core.impact import Impact
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.state import State
from omnipuck_sim.robot.walks import Touch


@dataclass(frozen=True, eq=False, kw_only=True)
class TrialResult(RunRecord):
    """The record of one run (simulated), whose times are simulated time and whose track is the truth."""

    world: str
    strategy: str
    seed: int
    outcome: str  # reached, timeout, stuck, or aborted where the planner gave the goal up
    reason: str  # of another outcome than reached
    timeout: float  # longest time that it may take [s]
    plans: tuple[np.ndarray, ...]  # the reference positions (n, 2) of each
    movers: np.ndarray  # (m, k, 5) x, y [m], vx, vy [m/s], radius [m] of each, at the times of the trajectory
    touches: tuple[Touch, ...]  # of movers, their times as in the trajectory

    @property
    def reached(self) -> bool:
        """Whether the robot reached its goal."""
        return self.outcome == REACHED

    @property
    def arrival_time(self) -> float:
        """Time from the first non-zero command to the first pose within goal_tolerance, else the limit [s]."""
        return self.elapsed if self.reached else self.timeout

    @cached_property
    def trajectory(self) -> np.ndarray:
        """(m, 5) t, x, y, vx, vy of the truth at the mocap rate, t from the first non-zero command."""
        return np.column_stack([self.track[:, 0] - (self.begin or 0.0), self.track[:, 1:]])

    @property
    def foreseen(self) -> np.ndarray:
        """(k,) whether a plan in force foresaw each impact."""
        return self.verdicts.foreseen

    @property
    def deliberate(self) -> np.ndarray:
        """(k,) and whether it was deliberate too."""
        return self.verdicts.deliberate

    @property
    def rebounds(self) -> np.ndarray:
        """(k, 3) angle between the direction foreseen and the true one [rad], speed foreseen and true [m/s], or NaN."""
        return self.verdicts.rebounds

    @property
    def plan_times(self) -> np.ndarray:
        """(n,) wall time of each cycle from scan to plan [s]."""
        return self.planning_times / 1e3

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
        self._maneuvers: list[str] = []
        self._commands: list[tuple[float, ...]] = []

    def planned(self, plan: Plan, planning_time: float) -> None:
        """Takes a plan, and the wall time in which it was made [s]."""
        self._plans.append(plan)
        self._plan_times.append(planning_time)

    def commanded(self, command: Command, now: float) -> None:
        """Takes a command given at `now` [s]; time counts from the first one that moves the robot."""
        self._maneuvers.append(command.maneuver)
        self._commands.append((now, *command.velocity.tolist(), command.yaw_rate))
        if self._begun is None and command.velocity.any():
            self._begun = now

    def moved(self, truth: State, movers: np.ndarray) -> None:
        """Takes the true state of the robot, and of the movers (k, 5)."""
        if self._begun is not None:
            self._rows.append((truth.stamp, *truth.position.tolist(), *truth.velocity.tolist()))
            self._movers.append(movers)

    def result(self, outcome: str, reason: str, arrived: float) -> TrialResult:
        """The record of the whole run, why it ended so, and the stamp of the pose with which it ended [s]."""
        commands, plans = np.array(self._commands).reshape(-1, 4), self._plans
        return TrialResult(
            world=self._world,
            strategy=self._settings.planner.strategy,
            seed=self._seed,
            outcome=outcome,
            reason=reason,
            timeout=self._settings.trial.timeout,
            begin=self._begun,
            arrived=arrived,
            track=np.array(self._rows).reshape(-1, 5),
            is_true=True,
            impacts=tuple(self.impacts),
            predictions=[Prediction(plan.stamp, plan.contacts) for plan in plans],
            planning_times=1e3 * np.array(self._plan_times),
            candidates=np.array([len(plan.candidates.costs) for plan in plans], dtype=int),
            candidates_before_pruning=np.array([plan.n_before_pruning for plan in plans], dtype=int),
            commands=commands,
            commanded=self._maneuvers,
            sent=commands[:, 0],
            plans=tuple(plan.positions for plan in plans),
            movers=np.array(self._movers) if self._movers else np.zeros((0, 0, 5)),
            touches=tuple(touch._replace(time=touch.time - (self._begun or 0.0)) for touch in self.touches),
        )
