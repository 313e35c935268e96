"""The simulated Omnipuck as a robot on the graph: takes cmd_vel, gives the poses of a motion capture and the truth."""

from collections.abc import Callable
from dataclasses import replace
from math import floor

import numpy as np
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage
from std_srvs.srv import Trigger

from collplan_core.params import Control, Frames, Limits, Robot, Simulation
from collplan_core.tracking import clip_command
from collplan_core.worlds import load_world
from collplan_ros.clock import seconds
from collplan_ros.conversions import (
    MessageError,
    impact_to_message,
    pose_to_message,
    stamp_from_seconds,
    state_to_odometry,
    velocity_from_twist,
)
from collplan_ros.diagnostics import OK, WARN, Diagnostics, Health
from collplan_ros.node_parameters import declare, read_settings
from collplan_ros.qos import EVENT, NEWEST, POSE_PUBLISHED
from collplan_ros.run_node import run_node
from omnipuck_sim.pacing import Pacing
from omnipuck_sim.physics import Simulator
from omnipuck_sim.rebound import Impact

GROUPS = (Robot, Simulation, Limits, Control, Frames)
FASTEST_TIMER = 0.001
"""Shortest period of the timer; what is due between two calls is then published together [s]."""


class SimulatorNode(Node):
    """Runs in real time, stamped by the node's clock, or at another speed factor, where it publishes /clock."""

    def __init__(self, **kwargs: object) -> None:
        super().__init__("simulator_node", **kwargs)
        declare(self, *GROUPS)
        self._settings = read_settings(self, *GROUPS)
        simulation = self._settings.simulator
        self._simulator = Simulator(load_world(simulation.world), self._settings, simulation.seed)
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._pacing = Pacing(simulation.physics_rate, simulation.speed_factor, seconds(self._steady))
        self._epoch = 0.0
        self._poses = 0
        self._estopped = False
        self._last_refused = False
        self._counts = {"commands": 0, "clipped": 0, "refused": 0, "impacts": 0}
        self._make_outputs(publish_clock=simulation.speed_factor != 1.0)
        self._make_inputs(stamped=self._settings.controller.stamped_cmd_vel)
        period = max(1.0 / (simulation.mocap_rate * simulation.speed_factor), FASTEST_TIMER)
        self._timer = self.create_timer(period, self._advance, clock=self._steady)
        self._diagnostics = Diagnostics(self, self._health)

    def _make_outputs(self, publish_clock: bool) -> None:
        self._pose_publisher = self.create_publisher(PoseStamped, "mocap/pose", POSE_PUBLISHED)
        self._odometry_publisher = self.create_publisher(Odometry, "ground_truth/odom", EVENT)
        self._impact_publisher = self.create_publisher(Vector3Stamped, "ground_truth/impact", EVENT)
        self._clock_publisher = self.create_publisher(ClockMessage, "/clock", NEWEST) if publish_clock else None

    def _make_inputs(self, stamped: bool) -> None:
        if stamped:
            self.create_subscription(TwistStamped, "cmd_vel", lambda m: self._take_command(m.twist), NEWEST)
        else:
            self.create_subscription(Twist, "cmd_vel", self._take_command, NEWEST)
        self._serve("reset", self._reset)
        self._serve("estop", self._stop_latched)
        self._serve("clear_estop", self._clear_stop)

    def _serve(self, name: str, act: Callable[[], str]) -> None:
        def answer(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            self._advance()
            response.success, response.message = True, act()
            return response

        self.create_service(Trigger, name, answer)

    def _advance(self) -> None:
        """Brings the simulation to the present and publishes what it met on the way."""
        steps = self._pacing.due(seconds(self._steady))
        if self._clock_publisher is None:
            # only after a stall or a step of the system's clock this changes by more than the clocks' reading time
            target = self._simulator.time + steps / self._settings.simulator.physics_rate + self._pacing.ahead
            self._epoch = seconds(self.get_clock()) - target
        for _ in range(steps):
            self._simulator.step()
            self._publish_poses()
        for impact in self._simulator.take_impacts():
            self._publish_impact(impact)

    def _publish_poses(self) -> None:
        due = floor(self._simulator.time * self._settings.simulator.mocap_rate + 1e-6)
        if due <= self._poses:
            return
        self._poses = due
        frames, stamp = self._settings.frames, self._epoch + self._simulator.time
        if self._clock_publisher is not None:
            self._clock_publisher.publish(ClockMessage(clock=stamp_from_seconds(stamp)))
        measured = replace(self._simulator.measured_pose(), stamp=stamp)
        self._pose_publisher.publish(pose_to_message(measured, frames.map))
        truth = replace(self._simulator.state, stamp=stamp)
        self._odometry_publisher.publish(state_to_odometry(truth, frames.map, frames.base))

    def _publish_impact(self, impact: Impact) -> None:
        self._counts["impacts"] += 1
        change = impact.velocity_after - impact.velocity_before
        self._impact_publisher.publish(impact_to_message(self._epoch + impact.time, change, self._settings.frames.map))

    def _take_command(self, twist: Twist) -> None:
        self._advance()
        if self._estopped:
            return
        self._counts["commands"] += 1
        velocity, yaw_rate = self._checked(twist)
        self._simulator.command(velocity, yaw_rate)

    def _checked(self, twist: Twist) -> tuple[np.ndarray, float]:
        """The command as far as the robot follows it; zero where it refuses."""
        try:
            velocity, yaw_rate = velocity_from_twist(twist)
            accepted = clip_command(velocity, yaw_rate, self._settings.robot, self._settings.limits)
        except MessageError:
            accepted = None
        self._last_refused = accepted is None
        if accepted is None:
            self._counts["refused"] += 1
            return np.zeros(2), 0.0
        self._counts["clipped"] += not np.array_equal(accepted[0], velocity)
        return accepted

    def _reset(self) -> str:
        self._simulator.reset()
        return "back at the start, at rest"

    def _stop_latched(self) -> str:
        self._estopped = True
        self._simulator.command(np.zeros(2), 0.0)
        return "stopped; commands are ignored until clear_estop"

    def _clear_stop(self) -> str:
        self._estopped = False
        return "commands are taken again"

    def _health(self) -> Health:
        values = {**self._counts, "simulated_time": self._simulator.time, "time_lost_in_stalls": self._pacing.lost}
        if self._estopped:
            return Health(WARN, "emergency stop: commands are ignored", values)
        if self._last_refused:
            return Health(WARN, "last command refused: not finite or too fast", values)
        return Health(OK, "simulated", values)


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable."""
    return run_node(SimulatorNode, args)
