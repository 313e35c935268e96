"""The controller's decisions: who commands, which plan to follow, and a command each period, without exception.

Manual control has priority: while a person's commands arrive the robot is driven by them. It is held from the first
one on, so that it stands when they end. Otherwise the command is zero unless a goal is active, pose, scan and
plan are fresh, and the robot is within the fence. Where that was not so for LONGEST_FAULT, where it moves late or
against its commands, or where it was carried, the robot is held until there is a new goal or a person calls resume. A
plan is followed once the pose it begins at and a scan of then or before have come, with the local map of the newest
such scan. `mover_guard` checks every command last, a person's above limits.blind_speed too: the robot does not drive
into what moves. Waiting for that is no reason to hold the robot.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from collplan_core.command import Command, stopped
from collplan_core.control.brush import Brush
from collplan_core.control.drive_record import BY_STAMP
from collplan_core.control.follow import ControllerMemory, clip_command, follow, saturate
from collplan_core.control.interlock import REMEDY, Hold
from collplan_core.control.manual_override import TAKEN, ManualCommand, overrides, overriding_command, why_no_override
from collplan_core.control.motion_monitor import STOPPING
from collplan_core.control.permission import why_outside, why_refuse_plan, why_stale
from collplan_core.goal import NOT_GIVEN, Goal
from collplan_core.learning.drive import with_drive
from collplan_core.local_map import LocalMap
from collplan_core.loop.delay_prediction import motion_under_way
from collplan_core.loop.drive_watch import NEARBY, DriveWatch
from collplan_core.loop.input_gate import InputGate, Refusals
from collplan_core.loop.motion_watch import MotionWatch
from collplan_core.loop.mover_guard import kept_off
from collplan_core.loop.sensed_scans import SensedScans
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.poses.pose_filter import KIDNAPPED
from collplan_core.scan import Scan
from collplan_core.state import State

LONGEST_START = 10.0
"""Time for the first plan of a goal, and for the first poses and scans [s]; nothing else may take so long."""
LONGEST_RESUMED = 3.0
"""The same time after a person let the robot go on [s]: inputs must be there then, and a plan soon."""
NOT_VOUCHED = "nothing vouches for its scans: no wall is near, limits.unvouched_speed"
"""Reason for a speed that is limited, or would be."""
BRUSHED = "brushed: it stands, or goes on slowly at limits.blind_speed"
"""Reason for standing, or a speed that is limited, after a contact that moved the robot a little."""
WHY_KIDNAPPED = "the robot was carried or turned, or another body is taken for it"
"""Reason for a hold after poses have jumped and agree with one another elsewhere, or after an unexplained turn."""


@dataclass(frozen=True, eq=False)
class Following:
    """The plan being followed, if any, and how far."""

    waiting: Plan | None = None  # a newer plan, whose pose or scan has not come
    plan: Plan | None = None
    local_map: LocalMap | None = None  # of the newest scan that was there when the plan was made
    memory: ControllerMemory = field(default_factory=ControllerMemory)


class ControllerLoop:
    """Takes poses, scans, goals and plans, each with the local time of receipt [s]; gives a command at each tick."""

    def __init__(
        self, settings: Settings, why_forbidden: Callable[[], str] = lambda: "", sensed: SensedScans | None = None
    ) -> None:
        """Starts at rest; `why_forbidden` returns an external reason to stand still, empty where there is none.

        `sensed` is that of a planner which is given the same poses and scans; one of its own by default.
        """
        self.goal = NOT_GIVEN  # the present goal of planner and robot
        self.refusals = Refusals()  # counts of what was refused
        self.motion = MotionWatch()  # monitoring of the robot's motion, compared with its commands
        self.drive = DriveWatch(settings)  # the drive in use, and what was learnt of it
        # why a person who has the robot is not followed, or limited to limits.blind_speed; "" without
        self.override_trouble = ""
        self._settings = self._given = settings
        self._why_forbidden = why_forbidden
        self._inputs = InputGate(sensed or SensedScans(settings.limits.pose_history), self.refusals)
        self._following = Following()
        self._hand: ManualCommand | None = None
        self._robot_stands = ""
        self._sent = stopped("just started")
        self._hold = Hold(patience=LONGEST_START)

    def change_settings(self, settings: Settings) -> None:
        """Uses other settings from now on."""
        self._given, self._settings = settings, with_drive(settings, self.drive.in_use)

    @property
    def settings(self) -> Settings:
        """The settings in use, with the drive that was learnt."""
        return self._settings

    @property
    def goal_active(self) -> bool:
        """True where there is a goal that the robot is to drive to."""
        return self.goal.active

    @property
    def goal_status(self) -> str:
        """Status of the newest goal."""
        return self.goal.status

    @property
    def held(self) -> str:
        """Reason why only a new goal or `resume` lets the robot move; "" where neither is needed."""
        return self._hold.interlock.reason

    @property
    def plan(self) -> Plan | None:
        """The plan being followed."""
        return self._following.plan

    def now(self, local: float) -> float | None:
        """The time on the poses' clock [s]; None before the first pose."""
        return self._inputs.now(local)

    # ---- inputs

    def take_pose(self, state: State, local: float) -> None:
        """Takes a pose."""
        joins = self._inputs.take_pose(state, local, self._settings)
        self.motion.take_pose(state, local, joins, self._settings, self._inputs.sensed.movers)
        self.drive.take_pose(self.motion.drive, joins, self.motion.pushed)
        if not joins:
            self._following = Following()

    def take_impact(self, stamp: float, change: np.ndarray) -> None:
        """Takes an impact at `stamp` [s] that changed the velocity by `change` (2,) [m/s]."""
        state, reach = self._inputs.state, self._settings.robot.radius + NEARBY
        self.drive.take_impact(stamp, change, state is not None and self.motion.is_near(state, reach))

    def take_scan(self, scan: Scan, local: float) -> None:
        """Takes a scan."""
        self._inputs.take_scan(scan, local, self._settings)
        self.motion.take_scan(self._inputs.sensed.newest_placed(), self._settings)

    def refuse(self, kind: str, reason: str) -> None:
        """Takes a refused pose or scan (`kind` "pose" or "scan"), or a pose after KIDNAPPED, which is usable.

        The robot is then held, unless a person has let it go on while its poses were refused.
        """
        if kind == "pose":
            self.drive.refuse_pose()
        if kind == "pose" and reason.startswith(KIDNAPPED):
            if self.goal_active and not self.held and not self._hold.kidnapping_is_known:
                self._hold = self._hold.held(WHY_KIDNAPPED)
            return
        if kind == "pose" and not self._inputs.refuses_poses:
            self._hold = replace(self._hold, kidnapping_is_known=False)
        self._inputs.refuse(kind, reason)

    def forget_scans(self) -> None:
        """Takes a person's resume: where scans are refused, the next one is accepted."""
        self._inputs.forget_scans()

    def take_robot_state(self, reason: str) -> None:
        """Takes the reason why the robot itself stands, held or stopped; "" where it follows commands."""
        self._robot_stands = reason

    def take_manual_command(self, velocity: np.ndarray, yaw_rate: float, sent: float, trouble: str) -> None:
        """Takes a person's command: velocity (2,) [m/s, body frame], yaw rate [rad/s], when sent [s, local clock].

        `trouble` is the reason not to follow it; the robot then stands. Empty without one.
        """
        self._hand = ManualCommand(velocity, yaw_rate, sent, trouble)

    def take_goal(self, goal: Goal) -> None:
        """Takes the goal's identity, stamp and status; the position is not needed.

        A goal not received before releases a hold if it is active; a planner that starts without a goal does not.
        """
        if goal.active and goal.id not in self._hold.interlock.goals:
            self._remember(ControllerMemory())
            self._go_on(LONGEST_START)
        self._hold = replace(self._hold, interlock=self._hold.interlock.after_goal(goal.id))
        self.goal = goal
        plans = [plan for plan in (self._following.waiting, self.plan) if plan is not None]
        if not goal.active or any(plan.stamp <= goal.stamp for plan in plans):
            self._following = Following()

    def resume(self) -> None:
        """Lets the robot go on to its goal, on a person's request."""
        self._go_on(LONGEST_RESUMED)

    def _go_on(self, patience: float) -> None:
        # not while driving: goals in quick succession would stop the monitoring of its motion
        if self.held or not self.goal_active or self.motion.verdict.kind in STOPPING:
            self.motion.forget()
        self.motion.brush = Brush()
        # a person at rest may have let go, which their silence will show; one who goes on commanding keeps the robot
        if self._hand is not None and self._hand.is_rest:
            self._hand = replace(self._hand, released=True)
        self._hold = self._hold.resumed(patience, self._inputs.refuses_poses)
        self.forget_scans()

    def take_plan(self, plan: Plan, local: float) -> str:
        """Takes a plan, or the same again; returns why it is refused, or "" where it will be followed."""
        goal_stamp = self.goal.stamp if self.goal.active else None
        reason = why_refuse_plan(plan, goal_stamp, self._inputs.now(local), self._settings.limits.pose_age)
        if reason:
            return reason
        waiting = self._following.waiting
        if waiting is not None and waiting.stamp != plan.stamp:
            self.refusals.add("plan", f"no pose or no scan came for its stamp {waiting.stamp:.3f}")
        self._following = replace(self._following, waiting=plan)
        self._adopt()
        return ""

    def _adopt(self) -> None:
        """Starts to follow the waiting plan once its pose and a scan have come: topics have no common order."""
        plan, memory = self._following.waiting, self._following.memory
        # no pose is kept for a plan made before a break in the poses
        if plan is None or self._inputs.sensed.pose_at(plan.stamp) is None:
            return
        placed = self._inputs.sensed.newest_mapped(self._settings, until=plan.stamp)
        if placed is not None:
            self._following = Following(None, plan, placed.local_map, memory)

    def _remember(self, memory: ControllerMemory) -> None:
        self._following = replace(self._following, memory=memory)

    # ---- control

    def tick(self, local: float) -> Command:
        """Returns the command of one control period."""
        self.motion.judge(local, self._settings)
        if self.motion.verdict.kind in STOPPING:
            # until a person resumes: at a constant speed turned motion does not show, and is as wrong
            self._hold = replace(self._hold, mistrusted=self.motion.verdict.reason)
        self._adopt()
        hand, integral = self._hand, self._following.memory.integral
        if hand is not None and overrides(hand, local, self._settings.limits):
            command = self._kept_off(self._override(hand, local), None, local)
            self.override_trouble = self.override_trouble or command.reason
        else:
            self.override_trouble = ""
            wanted, acts = self._planned_command(local)
            command = self._kept_off(wanted, acts, local)
            if command is not wanted:
                # the position is off the reference because the robot waits, not because something pushes it
                self._remember(replace(self._following.memory, integral=integral))
        self.motion.commanded(command, local)
        if self.drive.commanded(command, self._inputs.now(local), self.motion.verdict.kind, self._robot_stands):
            self._settings = with_drive(self._given, self.drive.in_use)
        self._sent = command
        return command

    def _override(self, hand: ManualCommand, local: float) -> Command:
        limits, state = self._settings.limits, self._inputs.state
        # after manual control the planner drives again only when a person resumes, and with a new heading
        if not self.held and not hand.released:
            self._hold = self._hold.held(TAKEN)
        self._remember(ControllerMemory())
        lost = self._inputs.why_no_pose(local, limits)
        reason = why_no_override(hand, self._robot_stands, lost, None if state is None else state.position, limits)
        self.override_trouble = reason or lost or self._hold.mistrusted
        if reason:
            return stopped(f"by hand: {reason}")
        command = overriding_command(hand, self._sent, bool(self.override_trouble), self._settings)
        if command.reason:
            self.override_trouble = command.reason
            self.refusals.add("hand", command.reason)
        return command

    def _planned_command(self, local: float) -> tuple[Command, State | None]:
        """The command by the plan, and the robot when it acts; None where it stands."""
        reason = self._why_still(local)
        plan, shown, memory = self.plan, self._following.local_map, self._following.memory
        state, now = self._inputs.state, self._inputs.now(local)
        if reason or plan is None or shown is None or state is None or now is None:
            self._remember(ControllerMemory(heading=memory.heading))
            return stopped(reason), None
        settings, drive = self._settings, plan.drive
        if drive is not None and drive != self.drive.in_use:
            # a lead that suits another drive is none
            settings = with_drive(self._given, drive)
        state, now = self._when_it_acts(state, now, shown, settings)
        command, memory = follow(memory, plan, shown, state, now, settings)
        self._remember(memory)
        clipped = clip_command(command.velocity, command.yaw_rate, settings.robot, settings.limits)
        if clipped is None:
            self.refusals.add("command", f"{command.velocity.tolist()} m/s, {command.yaw_rate} rad/s")
            return stopped("the command is not finite or far beyond the limits"), None
        return self._vouched(replace(command, velocity=clipped[0], yaw_rate=clipped[1])), replace(state, stamp=now)

    def _vouched(self, command: Command) -> Command:
        """The command, slower where the robot was brushed, or no wall is near that would tell a scan which lies."""
        limits, state = self._settings.limits, self._inputs.state
        bounds = [] if self._inputs.sensed.vouched else [(limits.unvouched_speed, NOT_VOUCHED)]
        if state is not None and self.motion.brush.is_fresh(*state.position.tolist()):
            bounds.append((limits.blind_speed, BRUSHED))
        if not bounds or not command.velocity.any():
            return command
        most, reason = min(bounds)
        return replace(command, velocity=saturate(command.velocity, most), reason=reason)

    def _when_it_acts(self, state: State, now: float, local_map: LocalMap, settings: Settings) -> tuple[State, float]:
        """The robot when a command that is sent now acts, and the time then [s]; without a delay the newest pose."""
        delay = settings.robot.motion_delay
        if delay <= 0.0:
            return state, now
        told, ahead = self.motion.drive.told(BY_STAMP), now + delay - state.stamp
        state = motion_under_way(state, told, delay, ahead, local_map, settings).end
        return state, state.stamp

    def _kept_off(self, command: Command, acts: State | None, local: float) -> Command:
        """The command after the check against what moves; as it is where poses or scans show nothing by now."""
        # `acts` is the robot when the command acts, where that is known already.
        settings, sensed = self._settings, self._inputs.sensed
        state, now = self._inputs.state, self._inputs.now(local)
        nothing = len(sensed.movers) + len(sensed.unseen.edges) == 0 and settings.limits.emerging_speed == 0.0
        if nothing or state is None or now is None or self._inputs.why_stale(local, settings.limits):
            return command
        placed = sensed.newest_mapped(settings)
        if acts is None and placed is not None:
            state, now = self._when_it_acts(state, now, placed.local_map, settings)
        return kept_off(command, acts or replace(state, stamp=now), sensed.movers, placed, settings)

    def _why_still(self, local: float) -> str:
        """Returns the reason why the robot must not move now, "" where it may; a reason that lasts holds the robot."""
        forbidden = self._why_forbidden() or self._robot_stands
        reason = forbidden or self._stop_reason(local)
        if not self.goal_active:
            self._hold = self._hold.after("", "", local)
            return reason
        if not self.held:
            why = self.motion.why_hold(local, self._settings)
            lost = forbidden or self._inputs.why_lost(local, self._settings.limits)
            self._hold = self._hold.held(why) if why else self._hold.after(reason, lost, local)
        if self.held:
            return f"held: {self.held}; {REMEDY}"
        return reason or (BRUSHED if self.motion.brush.why else "")

    def _stop_reason(self, local: float) -> str:
        """Returns the reason why the robot must not move now, "" where it may, without regard to its motion."""
        if not self.goal_active:
            return "no active goal"
        limits, state = self._settings.limits, self._inputs.state
        outside = "" if state is None else why_outside(state.position, limits)
        stale, plan, now = self._inputs.why_stale(local, limits) or outside, self.plan, self._inputs.now(local)
        if stale:
            return stale
        if plan is None or now is None:
            return "no plan yet"
        age = limits.plan_age if plan.valid_until is None else plan.valid_until - plan.stamp
        return why_stale("plan", now - plan.stamp, age)
