"""The simulated Omnipuck as a robot on the graph: takes cmd_vel, gives the poses of a motion capture and the truth."""

from collections.abc import Callable
from typing import Any

import numpy as np
from std_srvs.srv import Trigger

from collplan_core.parameters import Cap, Control, Frames, Limits, Robot, Settings, Simulation
from collplan_ros.messages.status_values import REAL_TIME_FACTOR
from collplan_ros.node_kit.clock import seconds, steady_clock
from collplan_ros.node_kit.diagnostics import Health
from collplan_ros.node_kit.graph_node import GraphNode
from collplan_ros.node_kit.inputs import Inputs
from collplan_ros.node_kit.run_node import run_node
from collplan_ros.nodes.command_check import LIVE, check_caps
from collplan_ros.nodes.robot_contract import RobotContract
from omnipuck_sim.node.pacing import RealTimeFactor
from omnipuck_sim.node.simulated_mocap import MOCAP_LIVE, SimulatedMocap

GROUPS = (Robot, Cap, Simulation, Limits, Control, Frames)


class SimulatorNode(GraphNode):
    """Takes commands as the real robot does, but without a line that could be bad.

    Simulated time passes by the local clock from `start` on, or else pose by pose, whenever `grant` is called.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__("simulator_node", GROUPS, (*LIVE, *MOCAP_LIVE), check_caps, **kwargs)
        self._room = SimulatedMocap(self, self._settings)
        self._inputs = Inputs(self)
        self._advance: Callable[[], object] = lambda: None
        self._steady = steady_clock()
        self._factor = RealTimeFactor(self._room.simulator.time, seconds(self._steady))
        simulated = (lambda: self._room.simulator.time) if self._room.publishes_clock else None
        self._contract = RobotContract(self, self._inputs, self, self._settings, simulated)
        self.create_service(Trigger, "reset", self._reset)
        self._begin(self._inputs)
        self._inputs.ready(self._room.description)

    def start(self) -> None:
        """Lets simulated time follow the local clock from now on; ParameterError: simulator.speed_factor is 0."""
        self._advance = self._room.advance
        self._room.start(self._advance)

    def grant(self) -> float:
        """Lets simulated time pass until a pose has been measured or sent; returns it [s]."""
        self._room.grant()
        return self._room.simulator.time

    # ---- what the contract needs

    def now(self) -> float:
        """The simulated time, after the simulation was brought to the present [s]."""
        self._advance()
        return self._room.simulator.time

    def is_ready(self) -> bool:
        """Always: there is no line between this node and the wheels."""
        return True

    def follow(self, velocity: np.ndarray, yaw_rate: float, age: float) -> None:
        """Commands the wheels from now on: velocity (2,) [m/s, robot frame] and yaw rate [rad/s] of this age [s]."""
        self._advance()
        self._room.simulator.command(velocity, yaw_rate, age)

    def halt(self) -> None:
        """Commands zero."""
        self.follow(np.zeros(2), 0.0, 0.0)

    def why_stay_stopped(self) -> str:
        """Nothing keeps the emergency stop latched."""
        return ""

    def why_not_start(self) -> str:
        """Nothing: it has neither battery nor motors."""
        return ""

    # ---- its own

    def _change(self, settings: Settings) -> None:
        self._contract.change_settings(settings)

    def _reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._advance()
        self._room.simulator.reset()
        response.success, response.message = True, "back at the start, at rest"
        self.get_logger().info(f"reset: {response.message}")
        return response

    def _health(self) -> Health:
        contract, room = self._contract, self._room
        time = room.simulator.time
        values = {**contract.counts, "impacts": room.impacts, "simulated_time": time, "time_stalled": room.stalled}
        if room.publishes_clock:
            values[REAL_TIME_FACTOR] = self._factor.measured(time, seconds(self._steady))
        return contract.health(values, "", "simulated")


def _started() -> SimulatorNode:
    node = SimulatorNode()
    node.start()
    return node


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable."""
    return run_node(_started, args)
