"""The record of a run, which trials and recordings both fill, and what is made from it alone."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from collplan_core.evaluation.impact_matching import Prediction, Verdicts, judge_impacts
from collplan_core.evaluation.run_end import measured_path_length, path_length
from collplan_core.impact import Impact

HARD = 0.3
"""Speed into the obstacle from which a rebound tells the restitution [m/s]."""


@dataclass(frozen=True, eq=False, kw_only=True)
class RunRecord:
    """Record of a run: times are stamps on the poses' clock [s], vectors are in the world frame."""

    begin: float | None  # of the first command that moves the robot; None without one
    arrived: float  # of the pose with which the run ended
    track: np.ndarray  # (m, 5) time, x, y, vx, vy from `begin` on: the truth where it is known, else as measured
    is_true: bool  # whether the track is the truth
    impacts: tuple[Impact, ...]
    """All k of the run, in order of time. Of a simulated robot: contacts begun at more than 0.08 m/s into the wall;
    contacts within 50 ms of one on the same surface belong to it. Of a real robot: what was detected in the poses or
    sensed by the ring."""
    predictions: Sequence[Prediction]  # of every plan, in order of time
    planning_times: np.ndarray  # (n,) wall time of each cycle from scan to plan [ms]
    candidates: np.ndarray  # (n,) their number in each cycle
    candidates_before_pruning: np.ndarray  # (n,)
    commands: np.ndarray  # (c, 4) time, velocity [m/s, body frame] and yaw rate [rad/s]
    commanded: Sequence[str]  # (c,) the maneuver of each
    sent: np.ndarray  # (c,) when each was sent [s, its sender's clock]

    @cached_property
    def verdicts(self) -> Verdicts:
        """Which impacts were foreseen, which deliberate, and how well."""
        return judge_impacts(self.impacts, self.predictions)

    @property
    def speeds(self) -> np.ndarray:
        """Speed of each impact into the obstacle (k,) [m/s]."""
        return np.array([impact.speed_into for impact in self.impacts])

    @property
    def restitutions(self) -> list[float]:
        """Share of the speed into the obstacle that came back, of each impact that is hard enough to tell it."""
        hard = (each for each in self.impacts if each.speed_into >= HARD and not each.with_mover)
        return [float(each.velocity_after @ each.normal) / each.speed_into for each in hard]

    @property
    def elapsed(self) -> float:
        """Time from the first command to move to the end [s]; 0 without one."""
        return 0.0 if self.begin is None else self.arrived - self.begin

    @cached_property
    def path_length(self) -> float:
        """Length of the track [m]; a measured one is filtered first."""
        times, positions = self.track[:, 0], self.track[:, 1:3]
        return path_length(positions) if self.is_true else measured_path_length(times, positions)

    @property
    def driven(self) -> np.ndarray:
        """(c,) whether each command was given at `begin` or later."""
        return self.commands[:, 0] >= (np.inf if self.begin is None else self.begin)

    @property
    def maneuvers(self) -> dict[str, int]:
        """Control periods spent in each maneuver."""
        return dict(Counter(self.commanded))
