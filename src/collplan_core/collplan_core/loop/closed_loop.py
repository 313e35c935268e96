"""Planner and controller of one robot, connected: poses, scans and time in, commands out. Without ROS."""

from collections.abc import Callable
from time import perf_counter
from typing import ParamSpec

import numpy as np

from collplan_core.command import Command
from collplan_core.deadline import Deadline, never
from collplan_core.goal import Goal
from collplan_core.learning.drive import Drive
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.decisions import Cycle, Decision
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.loop.sensed_scans import SensedScans
from collplan_core.parameters import Settings
from collplan_core.replay.journal import CONTROLLER, PLANNER, Journal
from collplan_core.scan import Scan
from collplan_core.state import State

P = ParamSpec("P")
ONLY_GOAL = b"the only goal..."


class ClosedLoop:
    """The two loops as the nodes connect them, for one goal. Each input has its time of receipt [s]."""

    def __init__(
        self,
        settings: Settings,
        heard: Callable[[Decision, float], None] = lambda decision, local: None,
        make_deadline: Callable[[Settings], Deadline] = lambda settings: never,
        known_map: object = None,
        journals: tuple[Journal, Journal] | None = None,
    ) -> None:
        """Starts without a goal.

        Args:
            heard: told each decision of the planner and its time [s], after the controller has it.
            make_deadline: makes the time limit of a plan.
            known_map: map that the planner is given; None for none.
            journals: of planner and controller, which keep what they are given; None keeps nothing.
        """
        planner, controller = journals or (Journal(PLANNER), Journal(CONTROLLER))
        sensed = SensedScans(settings.limits.pose_history)
        self.planner = PlannerLoop(settings, planner.count_checks(make_deadline), known_map, sensed=sensed)
        self.controller = ControllerLoop(settings, sensed=sensed)
        self.planning_time = 0.0  # wall time of the planner's newest decisions [s]
        self._heard = heard
        self._drive: Drive | None = self.controller.drive.in_use
        self._to_planner, self._to_controller = planner.call, controller.call

    def take_goal(self, position: np.ndarray, local: float) -> None:
        """Begins to drive to a goal (2,) [m]."""
        self._decide(local, self.planner.take_goal, ONLY_GOAL, position, local)

    def take_pose(self, state: State, local: float, impact: tuple[float, np.ndarray] | None = None) -> None:
        """Takes a pose, and the impact that it shows: its stamp [s] and the change of velocity (2,) [m/s]."""
        self._to_controller(self.controller.take_pose, state, local)
        if impact is not None:
            self.take_impact(*impact, local)
        self._decide(local, self.planner.take_pose, state, local)

    def take_impact(self, stamp: float, change: np.ndarray, local: float) -> None:
        """Takes an impact at `stamp` [s] that changed the velocity by `change` (2,) [m/s]."""
        self._to_controller(self.controller.take_impact, stamp, change)
        self._decide(local, self.planner.take_impact, stamp, change, local)

    def refuse_pose(self, reason: str) -> None:
        """Notes that a pose cannot be used."""
        self._to_controller(self.controller.refuse, "pose", reason)

    def take_scan(self, scan: Scan, local: float) -> None:
        """Takes a scan."""
        self._to_planner(self.planner.take_scan, scan, local)
        self._to_controller(self.controller.take_scan, scan, local)

    def plan(self, local: float) -> None:
        """Plans, where the planner can."""
        self._decide(local, self.planner.cycle, local)

    def tick(self, local: float) -> Command:
        """Returns the command of a control period."""
        command = self._to_controller(self.controller.tick, local)
        self._to_planner(self.planner.take_command, command.velocity, local)
        drive = self.controller.drive.in_use
        if drive is not None and drive != self._drive:
            self._drive = drive
            self._to_planner(self.planner.take_drive, *drive)
        return command

    def _decide(self, local: float, decide: Callable[P, list[Decision]], *given: P.args, **named: P.kwargs) -> None:
        begun = perf_counter()
        decisions = self._to_planner(decide, *given, **named)
        self.planning_time = perf_counter() - begun
        for decision in decisions:
            if isinstance(decision, Goal):
                self._to_controller(self.controller.take_goal, decision)
            elif isinstance(decision, Cycle):
                self._to_controller(self.controller.take_plan, decision.plan, local)
            self._heard(decision, local)
