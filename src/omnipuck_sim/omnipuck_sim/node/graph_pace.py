"""The pace of simulated time: real time, which in lockstep waits for the nodes of the graph."""

import math

from rclpy.node import Node
from sensor_msgs.msg import TimeReference

from collplan_core.parameters import Settings
from collplan_ros.messages.qos import EVERY_ONE
from collplan_ros.node_kit.clock import seconds, steady_clock
from collplan_ros.node_kit.input_watch import EVENT
from collplan_ros.node_kit.inputs import Inputs
from collplan_ros.node_kit.turn import END, STEP, TOPIC
from omnipuck_sim.node.lockstep import Lockstep
from omnipuck_sim.node.simulated_mocap import SimulatedMocap
from omnipuck_sim.node.simulated_times import SimulatedTimes

SHORTEST_MEASUREMENT = 0.5
"""Real time over which the real-time factor is measured at least [s]."""

COMMANDERS = ("controller_node", "bringup")
"""The nodes that command the robot; bringup does in a check."""


class GraphPace:
    """Brings the simulation of a room to the present, but no further than the nodes of the graph allow.

    Attributes:
        times: the simulated time, for the ages of messages.
    """

    def __init__(self, node: Node, inputs: Inputs, settings: Settings, room: SimulatedMocap) -> None:
        """Subscribes to the nodes' reports through `inputs`, in lockstep."""
        self.times = SimulatedTimes(room.simulator)
        self._log = node.get_logger()
        self._room = room
        self._clock = steady_clock()
        self._lockstep = _lockstep(settings)
        self._measured, self._factor = (seconds(self._clock), room.simulator.time), 1.0
        self._is_on = settings.simulator.lockstep
        if self._is_on:
            inputs.listen(TimeReference, TOPIC, self._take_report, EVERY_ONE, EVENT)

    def advance(self) -> None:
        """Lets simulated time pass up to the present, or up to where a node must be waited for."""
        simulator = self._room.simulator
        before = simulator.time
        self._room.advance(limit=self._lockstep.limit)
        self.times.leapt()
        if simulator.time > before or not self._room.waits:
            self._lockstep.goes_on()
            return
        # a node that has missed it would be waited for
        self._room.publish_clock()
        # at the start nodes compile, and a robot that rests loses nothing by a wait
        for node in self._lockstep.waits(simulator.time, seconds(self._clock), simulator.is_driven):
            self._log.warning(f"no report of {node} for simulator.patience: simulated time goes on without it")

    def values(self) -> dict[str, object]:
        """Figures of lockstep for the diagnostics, none without it; the real-time factor is of about a second."""
        if not self._is_on:
            return {}
        (then, time), now = self._measured, seconds(self._clock)
        if now - then >= SHORTEST_MEASUREMENT:
            self._measured = now, self._room.simulator.time
            self._factor = (self._room.simulator.time - time) / (now - then)
        wait = {"longest_wait_s": self._lockstep.longest_wait, "longest_wait_for": self._lockstep.longest_for}
        return {"real_time_factor": self._factor, **wait}

    def _take_report(self, message: TimeReference) -> None:
        until = message.time_ref.sec + 1e-9 * message.time_ref.nanosec
        node = message.source.rpartition("/")[2]
        if self._lockstep.report(node, math.inf if until >= END else until):
            self._log.info(f"{node} reports again: simulated time waits for it")
        if self._room.waits:
            self.advance()


def _lockstep(settings: Settings) -> Lockstep:
    simulator = settings.simulator
    # these report when a pose has come, and not with each
    pose = STEP + 1.0 / simulator.mocap_rate
    lateness = {
        **dict.fromkeys(COMMANDERS, simulator.controller_lateness),
        "planner_node": simulator.planner_lateness + pose,
    }
    return Lockstep(lateness, simulator.sensor_lateness + pose, simulator.patience)
