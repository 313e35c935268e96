"""Contract of a robot on the graph: the common behaviour of every robot, simulated or real, and the topic robot/state.

It takes cmd_vel and serves estop, clear_estop and resume. It is held from its start, after an emergency stop, and after
a fault, until a person gives a new goal or calls resume; no command releases it.
"""

import math
from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node
from std_msgs.msg import Empty
from std_srvs.srv import Trigger

from collplan_core.ages import SmallestDelay, StallGuard
from collplan_core.control.interlock import LONGEST_FAULT, REMEDY, Interlock
from collplan_core.parameters import Settings
from collplan_ros.messages import qos
from collplan_ros.messages.conversions import command_type
from collplan_ros.messages.qos import EVENT, LATCHED, NEWEST
from collplan_ros.messages.reading import twist_of
from collplan_ros.messages.states import FREE, HELD, STOPPED, goal_from_status, status_message
from collplan_ros.node_kit.clock import seconds, steady_clock
from collplan_ros.node_kit.diagnostics import ERROR, WARN, Health
from collplan_ros.node_kit.inputs import EVENT as EVENT_INPUT
from collplan_ros.node_kit.inputs import Inputs
from collplan_ros.node_kit.publishers import Commanders
from collplan_ros.nodes.command_check import REFUSED, CommandCheck

AGAIN = 1.0
"""Period at which the present state is repeated [s]: after a restart a latched message can be seconds late."""


class RobotState:
    """Publishes robot/state, latched, at every change and each AGAIN; logs changes too."""

    def __init__(self, node: Node) -> None:
        """Publishes through `node`; `tell` is to be called with the first state."""
        self.name = self.message = ""  # FREE, HELD or STOPPED; why, and how to release it, empty where free
        self._knows_planner = False
        self._log = node.get_logger()
        self._source = node.get_fully_qualified_name()
        self._out = node.create_publisher(DiagnosticStatus, "robot/state", qos.LATCHED)
        self._status = DiagnosticStatus()
        node.create_timer(AGAIN, lambda: self._out.publish(self._status), clock=steady_clock())

    def tell(self, name: str, reason: str, remedy: str, knows_planner: bool) -> None:
        """Publishes FREE, HELD or STOPPED if it is another state, with the reason, empty where free, and the remedy.

        `knows_planner`: the planner was received, so a goal given from then on is a new one.
        """
        whole = f"held, {reason}" if name == HELD else reason
        message = f"{whole}: {remedy}" if reason else ""
        if (name, message, knows_planner) == (self.name, self.message, self._knows_planner):
            return
        is_news, is_first = (name, message) != (self.name, self.message), not self.name
        self.name, self.message, self._knows_planner = name, message, knows_planner
        level = DiagnosticStatus.OK if name == FREE else DiagnosticStatus.WARN
        values = {"state": name, "reason": reason, "knows_planner": "yes" if knows_planner else "no"}
        self._status = status_message(self._source, level, message, values)
        self._out.publish(self._status)
        if not is_news:
            return
        if name == FREE or is_first:
            self._log.info(message or "free: commands are followed")
        else:
            self._log.warning(message)


STARTED = "just started"
"""Reason why a robot is held that no person has let move yet."""
LOOK_PERIOD = 0.05
"""Time between two checks for a reason to hold the robot [s]."""


class ContractedRobot(Protocol):
    """Interface of a robot that the contract requires."""

    def now(self) -> float:
        """The time in which the ages of commands are measured [s, any one clock]."""

    def is_ready(self) -> bool:
        """Returns whether commands can be followed at all."""

    def follow(self, velocity: np.ndarray, yaw_rate: float, age: float) -> None:
        """Follows a velocity (2,) [m/s, robot frame] and a yaw rate [rad/s] of this age [s] from now on."""

    def halt(self) -> None:
        """Stands still at once."""

    def why_stay_stopped(self) -> str:
        """Returns the reason why the emergency stop cannot be cleared; "" where it can."""

    def why_not_start(self) -> str:
        """Returns the reason why it must not begin to move; "" where it may. A moving robot goes on."""


class RobotContract:
    """Commands, the interlock and the emergency stop of one robot."""

    def __init__(
        self,
        node: Node,
        inputs: Inputs,
        robot: ContractedRobot,
        settings: Settings,
        simulated: Callable[[], float] | None = None,
    ) -> None:
        """Subscribes through `inputs` and serves in `node`.

        Ages are measured in real time, or by the time `simulated` [s], which stands still while a message is under way.
        """
        self.stopped_by = ""  # cause of the latched emergency stop, in words; empty while it is not latched
        self._ignored = self.releases = self.clearances = 0
        self._node = node
        self._inputs = inputs
        self._robot = robot
        self._settings = settings
        self._interlock = Interlock(STARTED)
        self._check = CommandCheck(settings)
        self._delay = SmallestDelay()
        self._commands = self._late = 0
        self._taken_at = -math.inf
        self._simulated = simulated
        self._steady = steady_clock()
        self._stalls = StallGuard()
        self._commanders = Commanders(node, "cmd_vel")
        self._state = RobotState(node)
        self._resumed = node.create_publisher(Empty, "robot/resumed", EVENT)
        inputs.listen(command_type(settings.controller), "cmd_vel", self._take_command, NEWEST, EVENT_INPUT)
        inputs.listen(GoalStatus, "goal_status", self._take_goal, LATCHED, EVENT_INPUT)
        self._serve("estop", self._stop)
        self._serve("clear_estop", self._clear_stop)
        self._serve("resume", self._resume)
        node.create_timer(LOOK_PERIOD, self.look, clock=steady_clock())
        self._tell()

    def change_settings(self, settings: Settings) -> None:
        """Uses other settings from now on."""
        self._settings = settings
        self._check.change_settings(settings)

    def latch(self, by: str) -> None:
        """Latches the emergency stop; `by` names its cause: "by its service"."""
        self.stopped_by = by
        self._tell()

    def hold(self, reason: str) -> None:
        """Stands still until a person lets the robot move."""
        was_free = self.may_move
        self._interlock = self._interlock.held(reason)
        if was_free:
            self._robot.halt()
        self._tell()

    @property
    def may_move(self) -> bool:
        """True where the robot may move: neither stopped nor held."""
        return not self.stopped_by and not self._interlock.reason

    def health(self, values: Mapping[str, object], warning: str, well: str) -> Health:
        """A robot's health: figures by name, and the warning of a fault that does not stop it, or else `well`."""
        waits = self._state.message
        stands = waits if self.stopped_by or self._interlock.reason != STARTED else ""
        trouble = warning or (REFUSED if self._check.last_refused else "")
        return Health.of(values, waits or well, (ERROR, self._commanders.why_refused), (WARN, stands), (WARN, trouble))

    @property
    def counts(self) -> dict[str, object]:
        """State, and counts of commands by outcome, as values of a `Health`."""
        commands = {"commands": self._commands, "ignored": self._ignored, "late": self._late}
        return {"state": self._state.name, **commands, **self._check.counts}

    def look(self) -> None:
        """Holds the robot for a reason such as a second commander or silence. Notes stalls of this node."""
        now = self._now()
        self._stalls.tick(now)
        self._commanders.look(now)
        reason = self._why_hold()
        if reason and self.may_move:
            self.hold(reason)

    def _why_hold(self) -> str:
        if self._commanders.why_refused:
            return self._commanders.why_refused
        silence = self._robot.now() - self._taken_at
        return f"no fresh command for {silence:.1f} s" if silence > LONGEST_FAULT else ""

    # ---- commands

    def _now(self) -> float:
        return self._simulated() if self._simulated else seconds(self._steady)

    def _take_command(self, message: Twist | TwistStamped) -> None:
        now = self._now()
        if self._stalls.tick(now):
            self.look()
        is_first = math.isinf(self._delay.least)
        # the clocks of sender and receiver differ by a constant, until one of them is set
        self._delay, age = self._delay.measured(now if self._simulated else self._inputs.sent, now)
        self._commanders.took(self._inputs.number, now)
        # the first one's age is unknown, and messages queued in a stall were sent before its end
        if is_first or age >= self._settings.limits.command_age or now - age <= self._stalls.ended:
            self._late += 1
            return
        self._taken_at = self._robot.now()
        if self.may_move and self._commanders.why_refused:
            self.hold(self._commanders.why_refused)
        if not self.may_move or not self._robot.is_ready():
            self._ignored += 1
            return
        self._commands += 1
        velocity, yaw_rate = self._check.followed(twist_of(message), self._taken_at)
        self._robot.follow(velocity, yaw_rate, age)

    # ---- a person's actions

    def _take_goal(self, message: GoalStatus) -> None:
        goal = goal_from_status(message)
        is_new = self._interlock.is_new(goal.id, goal.active)
        self._interlock = self._interlock.after_goal(goal.id)
        if is_new and not self.stopped_by:
            self._release()
        self._tell()

    def _release(self) -> str:
        """Lets the robot move where no reason is against it; returns that reason."""
        reason = self._commanders.why_refused or self._robot.why_not_start()
        if reason:
            self.hold(reason)
            return reason
        self._taken_at = self._robot.now()
        if not self.may_move:
            self._delay = SmallestDelay()
            self.releases += 1
        self._interlock = self._interlock.resumed()
        self._tell()
        return ""

    def _resume(self) -> tuple[bool, str]:
        if self.stopped_by:
            return False, "the emergency stop is latched: clear it first (clear_estop)"
        reason = self._release()
        if reason:
            return False, reason
        self._resumed.publish(Empty())
        return True, "commands are followed"

    def _stop(self) -> tuple[bool, str]:
        self.stopped_by = "by its service"
        self._robot.halt()
        self._tell()
        return True, f"stopped until it is cleared (clear_estop); then {REMEDY}"

    def _clear_stop(self) -> tuple[bool, str]:
        reason = self._robot.why_stay_stopped()
        if reason:
            self._node.get_logger().warning(f"emergency stop not cleared: {reason}")
            return False, reason
        if self.stopped_by:
            self.stopped_by = ""
            self.clearances += 1
            self._interlock = self._interlock.held("after the emergency stop")
            self._tell()
        return True, f"cleared; to move, {REMEDY}"

    # ---- reports

    def _serve(self, name: str, act: Callable[[], tuple[bool, str]]) -> None:
        def answer(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            response.success, response.message = act()
            return response

        self._node.create_service(Trigger, name, answer)

    def _tell(self) -> None:
        knows_planner = bool(self._interlock.goals)
        if self.stopped_by:
            reason = f"emergency stop {self.stopped_by}"
            self._state.tell(STOPPED, reason, "commands are ignored until it is cleared (clear_estop)", knows_planner)
        elif self._interlock.reason:
            self._state.tell(HELD, self._interlock.reason, REMEDY, knows_planner)
        else:
            self._state.tell(FREE, "", "", knows_planner)
