"""The planner's heartbeat: it outlives long cycles, and the controller stops where it does not come."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped, Twist
from std_msgs.msg import Empty

from collplan_core.parameters import Limits
from collplan_ros.messages.conversions import goal_to_message
from collplan_ros.messages.qos import EVENT, LATCHED, NEWEST
from collplan_ros.node_kit.stall import StallGuard
from collplan_ros.nodes.controller_node import ControllerNode
from fake_robot import FakeRobot, hall

LIMIT = Limits().heartbeat_age
STOPPED_WITHIN = 0.30
"""From the freeze of the planner to the first zero command [s]."""
LONG = "from collplan_ros.nodes.planner_node import main; import sys; sys.exit(main(sys.argv))"


class Planner:
    """planner_node as a process of its own."""

    def __init__(self, *parameters: str) -> None:
        given = [word for parameter in parameters for word in ("-p", parameter)]
        self.process = subprocess.Popen([sys.executable, "-c", LONG, "--ros-args", *given])

    def __enter__(self) -> "Planner":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.send_signal(signal.SIGCONT)
        self.process.terminate()
        try:
            self.process.wait(20.0)
        finally:
            self.process.kill()

    def signal(self, number: int) -> float:
        """Sends a signal; when it was [s]."""
        os.kill(self.process.pid, number)
        return time.monotonic()


class Graph:
    """A robot that stands still, a controller in this process and a planner in another."""

    def __init__(self, ros) -> None:
        self.ros = ros
        self.robot = FakeRobot(ros, hall())
        self.controller = ros.make(ControllerNode)
        self.beats, self.commands = [], []
        ros.probe.create_subscription(Empty, "planner/heartbeat", lambda _: self.beats.append(time.monotonic()), NEWEST)
        ros.probe.create_subscription(Twist, "cmd_vel", self._on_command, NEWEST)
        self.statuses = ros.listen(GoalStatus, "goal_status", LATCHED)

    def _on_command(self, message: Twist) -> None:
        moves = bool(message.linear.x or message.linear.y)
        self.commands.append((time.monotonic(), moves, self.controller._outputs.command.reason))

    def drive(self) -> None:
        """Gives a goal and waits until the robot is commanded to move."""
        goals = self.ros.publisher(PoseStamped, "goal_pose", EVENT, timeout=60.0)
        assert self.ros.wait_until(lambda: self.beats, 60.0)

        def moves() -> bool:
            if not self.statuses or self.statuses[-1].status not in (1, 2):
                goals.publish(goal_to_message(np.array([2.0, 0.0]), "map"))
                self.ros.spin(0.5)
            return bool(self.commands and self.commands[-1][1])

        assert self.ros.wait_until(moves, 60.0)

    def stopped_after(self, begun: float) -> tuple[float, float]:
        """From `begun` to the first zero command that is followed by no other [s], and the longest stall here [s]."""
        guard, stall = StallGuard(0.0), 0.0

        def stopped() -> bool:
            nonlocal stall
            guard.tick(time.monotonic())
            stall = max(stall, guard.gap)
            return any(when > begun and not moving for when, moving, _ in self.commands)

        assert self.ros.wait_until(stopped, 5.0)
        return next(when for when, moving, _ in self.commands if when > begun and not moving) - begun, stall


@pytest.mark.soak
@pytest.mark.parametrize("how", [signal.SIGSTOP, signal.SIGKILL])
def test_a_planner_that_is_frozen_or_dead_stops_the_robot_at_any_map_period(ros, how):
    graph = Graph(ros)
    # a plan holds for 4.2 s at this period
    with Planner("planner.map_period:=2.0", "planner.recovery_tries:=100") as planner:
        for _ in range(5):  # a stall of this process says nothing of how long the robot goes on
            graph.drive()
            begun = planner.signal(how)
            took, stall = graph.stopped_after(begun)
            reason = graph.commands[-1][2]
            if took <= STOPPED_WITHIN or stall < 0.1 or how == signal.SIGKILL:
                break
            planner.signal(signal.SIGCONT)
    assert took <= STOPPED_WITHIN + stall
    assert reason.startswith("planner heartbeat 0.")
    assert reason.endswith(f"limit {LIMIT:.2f} s")


def test_a_planner_without_a_heartbeat_is_not_missed(ros):
    graph = Graph(ros)
    ros.spin(0.5)
    assert graph.controller._heartbeat.why_silent() == ""


def test_after_a_heartbeat_its_silence_stops_until_it_comes_again(ros):
    graph = Graph(ros)
    beat = ros.publisher(Empty, "planner/heartbeat", NEWEST)
    watch = graph.controller._heartbeat

    def beats() -> bool:
        beat.publish(Empty())
        ros.spin(0.02)
        return watch.why_silent() == "" and watch._heard is not None

    assert ros.wait_until(beats)
    assert ros.wait_until(lambda: watch.why_silent())
    assert ros.wait_until(lambda: graph.controller._outputs.command.reason.startswith("planner heartbeat"))
    assert ros.wait_until(beats)
