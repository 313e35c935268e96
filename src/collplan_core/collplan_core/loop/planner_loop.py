"""The planner's decisions: when to plan, from where, and when a goal has ended.

Once per map_period a plan is made if it can be: from the newest scan and the pose at its stamp, or from the newest pose
and all scans so far, as the planner requires; with some planners also at once after an impact. A new goal replaces the
old one. A goal ends when it is reached, canceled, where the robot cannot stand within its tolerance by the scan, not
reached within planner.goal_timeout by the local clock, or closed off for a while by the boundaries seen; when the robot
leaves the fence; when it was stuck too often; when a planner without memory came no nearer to it for long; and when the
robot has stayed about one place for long, before a mover or a way that closed there. A robot that is commanded and does
not move backs out along the way it came. The place then counts as an obstacle, until that leaves no way. When the poses
jump, stop or start over, memory is dropped and the goal gets a new stamp, which invalidates every earlier plan.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from collplan_core.control.drive_record import BY_STAMP
from collplan_core.control.permission import is_blocked, plan_lifetime, why_outside, why_refuse_goal, why_shows_itself
from collplan_core.deadline import Deadline
from collplan_core.goal import ABORTED, AT_REST, CANCELED, EXECUTING, NOT_GIVEN, SUCCEEDED, Goal
from collplan_core.learning.drive import DRIVE, Drive, drive_of, with_drive
from collplan_core.local_map import LocalMap, build_local_map
from collplan_core.loop.decisions import ERROR, INFO, WARNING, Cycle, Decision, Notice
from collplan_core.loop.delay_prediction import motion_under_way
from collplan_core.loop.impact_alarm import ImpactAlarm, why_not_now
from collplan_core.loop.input_gate import InputGate, Refusals
from collplan_core.loop.progress import Progress
from collplan_core.loop.recovery import Recovery
from collplan_core.loop.sensed_scans import PlacedScan, SensedScans
from collplan_core.movers.record import Movers
from collplan_core.parameters import Settings
from collplan_core.plan import NoPlan, Plan
from collplan_core.planners import Planner, local_mapping_of, map_period_of, planner_for
from collplan_core.scan import Scan, ScanError
from collplan_core.scans.filters import add_bumped_obstacles
from collplan_core.state import State

NOTICE_PAUSE = 1.0
"""Shortest time between two notices that there is no plan [s]."""
ALARM_PERIODS = 2.0
"""Shortest time between two plans made at once after impacts, in map_periods."""


@dataclass(frozen=True, eq=False)
class Given:
    """Settings and functions that a planner's loop is made with."""

    settings: Settings
    drive: Drive | None  # the drive that was learnt; None without learning
    in_use: Settings  # the settings with it
    make_deadline: Callable[[Settings], Deadline]
    known_map: Any
    why_forbidden: Callable[[], str]


@dataclass(frozen=True, eq=False)
class Planned:
    """Memory, speed and scan with which the next plan begins."""

    memory: Any  # the planner's
    speed: float  # top speed of the newest plan [m/s]
    placed: PlacedScan | None = None
    """The newest scan whose pose is known; bumped obstacles are in its local map, and not in the scan."""
    until: float = 0.0  # stamp after which a plan must begin [s]


class PlannerLoop:
    """Takes poses, scans, impacts and goals, each with the local time of receipt [s], and returns its decisions."""

    def __init__(
        self,
        settings: Settings,
        make_deadline: Callable[[Settings], Deadline],
        known_map: Any = None,
        why_forbidden: Callable[[], str] = lambda: "",
        sensed: SensedScans | None = None,
    ) -> None:
        """Starts without a goal.

        Args:
            make_deadline: gives the deadline of a cycle at its start.
            known_map: initial memory of each goal.
            why_forbidden: returns an external reason to make no plan, in each cycle; empty where there is none.
            sensed: record of a controller that takes the same poses and scans; one of its own by default.
        """
        self.goal = NOT_GIVEN  # the newest goal and its status
        self.refusals = Refusals()  # counts of what was refused
        self.trouble = ""  # reason why there is no plan or the goal has ended; empty while plans are made
        # plans made, impacts received, and plans that foresaw a contact faster than limits.impact_speed
        self.n_plans = self.n_impacts = self.n_hard_plans = 0
        drive = drive_of(settings.robot) if settings.robot.learning == DRIVE else None
        self._given = Given(settings, drive, settings, make_deadline, known_map, why_forbidden)
        self._inputs = InputGate(sensed or SensedScans(settings.limits.pose_history), self.refusals)
        self._alarm = ImpactAlarm()
        self._recovery, self._progress = Recovery(), Progress()
        self._planned = Planned(known_map, settings.robot.max_speed)
        self._reported = "", -math.inf  # kind of the newest trouble that was said, "" where it is over; when [s]
        self._decisions: list[Decision] = []

    def change_settings(self, settings: Settings) -> None:
        """Uses other settings from now on; another strategy begins without memory."""
        if settings.planner.strategy != self._given.settings.planner.strategy:
            self._planned = replace(self._planned, memory=self._given.known_map)
        self._given = replace(self._given, settings=settings, in_use=with_drive(settings, self._given.drive))

    @property
    def _settings(self) -> Settings:
        return self._given.in_use

    @property
    def _planner(self) -> Planner:
        return planner_for(self._settings.planner.strategy)

    @property
    def state(self) -> State | None:
        """State of the robot at the newest pose; None before the first."""
        return self._inputs.state

    @property
    def recovery_tries(self) -> int:
        """Number of times the robot was stuck on its way to the newest goal."""
        return self._recovery.tries

    @property
    def movers(self) -> Movers:
        """The movers that the scans so far show."""
        return self._inputs.sensed.movers

    # ---- inputs

    def take_pose(self, state: State, local: float) -> list[Decision]:
        """Takes a pose."""
        settings = self._settings
        if not self._inputs.take_pose(state, local, settings):
            self._forget_before(state.stamp)
        passes = not settings.planner.stop_at_goal or float(np.hypot(*state.velocity)) <= AT_REST
        if passes and self.goal.is_at(state.position, settings.planner.goal_tolerance):
            self._end_goal(SUCCEEDED)
        outside = why_outside(state.position, settings.limits)
        if outside and self.goal.active:
            self._give_up(outside)
        if self.goal.active:
            self._progress.moved(state.position, self.goal.position, settings.planner.goal_tolerance)
        stuck = self._recovery.moved(state, local, settings)
        if stuck and self.goal.active:
            self._recover(stuck, state)
        self._plan_after_impact(local)
        return self._decided()

    def take_command(self, velocity: np.ndarray, local: float) -> None:
        """Takes a velocity (2,) [m/s, body frame] that the robot is commanded from now on."""
        self._recovery.commanded(velocity, local)
        self._progress.commanded(velocity, local)

    def take_drive(self, max_acceleration: float, lag: float, delay: float) -> None:
        """Takes the drive that the controller uses from now on: [m/s^2], [s], [s]."""
        drive = Drive(max_acceleration, lag, delay)
        self._given = replace(self._given, drive=drive, in_use=with_drive(self._given.settings, drive))

    def take_manual_command(self) -> None:
        """Takes a person's command, which the robot follows instead of the plan."""
        self._recovery.led_by_hand()
        self._progress.leave()
        self._forget_plan()

    def take_scan(self, scan: Scan, local: float) -> None:
        """Takes a scan."""
        self._inputs.take_scan(scan, local, self._settings)

    def refuse(self, kind: str, reason: str) -> None:
        """Takes a refused pose or scan (`kind` "pose" or "scan")."""
        self._inputs.refuse(kind, reason)

    def forget_scans(self) -> None:
        """Takes a person's resume: where scans are refused, the next one is accepted."""
        self._inputs.forget_scans()

    def take_impact(self, stamp: float, change: np.ndarray, local: float) -> list[Decision]:
        """Takes an impact at `stamp` [s] that changed the velocity by `change` (2,) [m/s]."""
        settings = self._settings
        self.n_impacts += 1
        reason = why_not_now(stamp, self._inputs.now(local), settings.limits.pose_age)
        if not reason and self._inputs.state is not None:
            reason = self._alarm.raised(stamp, local, ALARM_PERIODS * map_period_of(settings.planner))
        if reason:
            self.refusals.add("impact", reason)
        else:
            self._plan_after_impact(local)
        return self._decided()

    def take_goal(self, identity: bytes, position: np.ndarray, local: float) -> list[Decision]:
        """Takes a goal (2,) [m], which replaces the previous one; the same goal again gets no more time or tries."""
        state = self._inputs.state
        reason = why_refuse_goal(position, None if state is None else state.position, self._settings.limits)
        if reason:
            return self.refuse_goal(identity, reason)
        again = self.goal.is_at(position, self._settings.planner.goal_tolerance)
        self._begin_goal(again)
        self._progress.may_be_open()
        if not again:
            self._progress.begin_goal(local)
        self.forget_scans()
        self.goal = Goal(identity, self._planned.until, position)
        self._decisions += [self.goal, Notice(INFO, f"goal {position[0]:.3f}, {position[1]:.3f} accepted")]
        return self._decided()

    def refuse_goal(self, identity: bytes, reason: str) -> list[Decision]:
        """Takes an invalid goal; this ends the previous one too."""
        self._begin_goal()
        self.goal = Goal(identity, self._planned.until, np.full(2, np.nan), ABORTED)
        self._decisions.append(self.goal)
        self._refuse_goal(reason)
        return self._decided()

    def _forget_plan(self) -> None:
        """Drops the plan in force, as the robot is led by something else; remembered boundaries stay."""
        memory = self._planned.memory
        self._planned = replace(self._planned, memory=None if memory is None else self._planner.without_plan(memory))

    def cancel(self) -> list[Decision]:
        """Ends an active goal."""
        if self.goal.active:
            self._end_goal(CANCELED)
        return self._decided()

    def _begin_goal(self, again: bool = False) -> None:
        self._planned = replace(self._planned, memory=self._given.known_map, until=self._inputs.newest_stamp)
        self.trouble = ""
        if again:
            self._recovery.repeat_goal()
        else:
            self._recovery.begin_goal()

    def _forget_before(self, stamp: float) -> None:
        """Drops memory and plans from before a break in the poses at `stamp` [s]; an active goal is kept."""
        self._planned = replace(self._planned, memory=self._given.known_map, placed=None, until=stamp)
        self._alarm.forget()
        self._recovery.forget()
        self._progress.begin_poses()
        self.trouble = ""
        if self.goal.active:
            # every plan made up to then is refused
            self.goal = replace(self.goal, stamp=stamp)
            self._decisions.append(self.goal)

    # ---- end of the goal

    def _end_goal(self, status: str) -> None:
        self.trouble, self._reported = "", ("", self._reported[1])
        self._become(status)

    def _become(self, status: str) -> None:
        if status != self.goal.status:
            self.goal = replace(self.goal, status=status)
            self._decisions += [self.goal, Notice(INFO, f"goal {status}")]

    def _give_up(self, reason: str) -> None:
        self._end_goal(ABORTED)
        self.trouble = f"goal given up: {reason}"
        self._decisions.append(Notice(ERROR, self.trouble))

    def _refuse_goal(self, reason: str) -> None:
        self.trouble = f"goal refused: {reason}"
        self.refusals.add("goal", reason)
        self._decisions.append(Notice(ERROR, self.trouble))

    # ---- planning

    def cycle(self, local: float) -> list[Decision]:
        """Plans once; called every map_period."""
        if self.goal.active:
            self._cycle(local)
        return self._decided()

    def why_stale(self, local: float) -> str:
        """Returns the reason why no plan is made: forbidden, or poses or scans unusable; "" where one is made."""
        return self._given.why_forbidden() or self._inputs.why_stale(local, self._settings.limits)

    def _plan_after_impact(self, local: float) -> None:
        due = self._alarm.is_due(self._inputs.state)
        if due and self._planner.replans_after_impact and self.goal.active:
            self._cycle(local)

    def _cycle(self, local: float) -> None:
        settings, now = self._settings, self._inputs.now(local)
        deadline, progress = self._given.make_deadline(settings), self._progress
        overdue = progress.why_overdue(local, settings.planner, self._planner.gives_up_closed_off_goal)
        if overdue:
            self._give_up(overdue)
            return
        stale, state = self.why_stale(local), self._inputs.state
        if stale or now is None or state is None:
            progress.may_be_open()
            progress.leave()
            self._report_no_plan("stale", stale, local)
            return
        stays = progress.why_no_further(state.position, self.goal.position, self.movers, settings.robot.fastest, local)
        if stays:
            self._give_up(stays)
            return
        if self._recovery.is_backing_out(now):
            return
        try:
            placed = self._newest_placed()
        except ScanError as error:
            self._report_no_plan("no_plan", str(error), local)
            return
        newest = self._inputs.sensed.scan_stamp or 0.0
        no_pose = f"no pose for the scan's stamp {newest:.3f}"
        if placed is None:
            self._report_no_plan("no_pose", no_pose, local)
            return
        initial = state if self._planner.starts_at_newest_pose else placed.state
        old = _why_too_old(initial, placed.scan, settings.limits.scan_age)
        if old:
            self._report_no_plan("stale", old, local)
        elif initial.stamp > self._planned.until:
            self._plan(initial, placed, now + plan_lifetime(map_period_of(settings.planner)), local, deadline)
        elif newest > self._planned.until:
            self._report_no_plan("no_pose", no_pose, local)

    def _newest_placed(self) -> PlacedScan | None:
        """Returns the newest scan whose pose is known, with its local map, which is made once per scan."""
        settings, before = self._settings, self._planned.placed
        placed = self._inputs.sensed.newest_mapped(settings, -math.inf if before is None else before.scan.stamp)
        if placed is not None and len(self._recovery.felt):
            shown = add_bumped_obstacles(placed.scan, placed.state, self._recovery.felt, settings.robot.radius)
            mapping, returns = local_mapping_of(settings), placed.local_map.returns
            felt = build_local_map(shown, placed.state, settings.robot, mapping, returns)
            placed = replace(placed, local_map=felt)
        self._planned = replace(self._planned, placed=placed or before)
        return self._planned.placed

    def _plan(self, initial: State, placed: PlacedScan, valid_until: float, local: float, deadline: Deadline) -> None:
        settings, goal = self._settings, self.goal.position
        reason = why_refuse_goal(goal, initial.position, settings.limits)
        if reason:
            self._end_goal(ABORTED)
            self._refuse_goal(reason)
            return
        if is_blocked(goal, placed.scan, placed.state, settings, local_mapping_of(settings)):
            tolerance = f"within planner.goal_tolerance, {settings.planner.goal_tolerance:g} m"
            place = f"{goal[0]:.3f}, {goal[1]:.3f}"
            reason = f"the robot cannot stand at {place} or {tolerance}, beside an obstacle that the scan shows"
            self._report_no_way(reason, local, gives_up=True)
            return
        settings, delay, shown = self._among_movers(settings), settings.robot.motion_delay, placed.local_map
        told = self._recovery.drive.told(BY_STAMP)
        before = motion_under_way(initial, told, delay, delay, shown, settings) if delay > 0.0 else None
        begin = initial if before is None else before.end
        try:
            plan, memory = self._planner.plan(self._planned.memory, shown, begin, goal, settings, deadline)
        except NoPlan as error:
            if error.memory is not None:
                self._planned = replace(self._planned, memory=error.memory)
            if len(self._recovery.felt):
                # they leave no way to the goal: the next cycle plans anew
                self._recovery.forget_felt()
                self._planned = replace(self._planned, placed=None)
                return
            self._report_no_way(str(error), local, self._planner.gives_up_closed_off_goal)
            return
        self._progress.planned(local)
        self._planned = replace(self._planned, memory=memory)
        self._decide_on(plan if before is None else before.before(plan), valid_until, shown)

    def _among_movers(self, settings: Settings) -> Settings:
        """The settings; among movers, with the speed that the controller keeps to where nothing vouches for scans."""
        # A plan that passes ahead of a person at v_max is late at limits.unvouched_speed, and stops in their way.
        sensed, fastest = self._inputs.sensed, settings.robot.max_speed
        most = fastest if sensed.vouched or len(sensed.movers) == 0 else min(settings.limits.unvouched_speed, fastest)
        if most != self._planned.speed:
            self._planned = replace(self._planned, speed=most)
            self._forget_plan()
        return settings if most == fastest else replace(settings, robot=replace(settings.robot, max_speed=most))

    def _report_no_way(self, reason: str, local: float, gives_up: bool) -> None:
        """Makes no plan; gives the goal up where that lasts, as a single noisy scan may be wrong."""
        placed = self._planned.placed
        shown = "" if placed is None else why_shows_itself(placed.scan, placed.state, self._settings.robot.radius)
        reason = shown or reason
        self._report_no_plan("no_plan", reason, local)
        closed_off = self._progress.why_closed_off(reason, local) if gives_up else ""
        if closed_off:
            self._give_up(closed_off)

    def _recover(self, stuck: str, state: State) -> None:
        """Backs out of a place where the robot is stuck, or gives the goal up where it was stuck too often."""
        recovery, most = self._recovery, self._settings.planner.recovery_tries
        where = f"stuck at {state.position[0]:.2f}, {state.position[1]:.2f}, {stuck}"
        if recovery.tries >= most:
            self._give_up(f"{where}; {most} tries of planner.recovery_tries made")
            return
        plan = recovery.begin(state, self._settings)
        self._decisions.append(Notice(WARNING, f"{where}; try {recovery.tries} of {most}"))
        self._forget_plan()
        if plan is not None and self._planned.placed is not None:
            lasts = float(plan.times[-1]) + plan_lifetime(map_period_of(self._settings.planner))
            self._decide_on(plan, lasts, self._planned.placed.local_map)

    def _decide_on(self, plan: Plan, valid_until: float, local_map: LocalMap) -> None:
        boundaries = None if (memory := self._planned.memory) is None else self._planner.boundaries(memory)
        self._progress.may_be_open()
        self._become(EXECUTING)
        held = replace(plan, valid_until=valid_until, drive=self._given.drive)
        self._decisions.append(Cycle(held, local_map, boundaries))
        kind, noticed = self._reported
        if kind:
            self._decisions.append(Notice(INFO, "plans again"))
        self._planned = replace(self._planned, until=plan.stamp)
        self.trouble, self._reported = "", ("", noticed)
        self.n_plans += 1
        self.n_hard_plans += plan.contacts.hardest > self._settings.limits.impact_speed

    def _report_no_plan(self, kind: str, reason: str, local: float) -> None:
        self.trouble = reason
        self.refusals.add(kind, reason)
        # once when it begins: it comes again every map_period
        before, noticed = self._reported
        if kind != before and not 0.0 <= local - noticed < NOTICE_PAUSE:
            self._reported = kind, local
            self._decisions.append(Notice(WARNING, f"no plan: {reason}"))

    def _decided(self) -> list[Decision]:
        decisions, self._decisions = self._decisions, []
        return decisions


def _why_too_old(initial: State, scan: Scan, limit: float) -> str:
    """Returns why no plan starts so long after the newest scan with known poses; "" where one does."""
    # the age counts from the first beam, and the next scan arrives after its last one
    limit += max(0.0, scan.time_increment * (len(scan.ranges) - 1))
    age = initial.stamp - scan.stamp
    return f"the newest pose is {age:.2f} s after the newest scan, limit {limit:.2f} s" if age > limit else ""
