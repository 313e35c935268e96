"""The simulated Omnipuck as a robot on the graph: takes cmd_vel, gives the poses of a motion capture and the truth."""

import numpy as np
from rclpy.node import Node
from std_srvs.srv import Trigger

from collplan_core.parameters import Cap, Control, Frames, Limits, Robot, Settings, Simulation
from collplan_core.parameters.spec import ParameterError
from collplan_ros.node_kit.diagnostics import Diagnostics, Health
from collplan_ros.node_kit.inputs import Inputs
from collplan_ros.node_kit.node_parameters import declare, on_change, read_settings
from collplan_ros.node_kit.run_node import run_node
from collplan_ros.node_kit.shared_constants import SharedConstants
from collplan_ros.nodes.caps import LIVE, check_caps
from collplan_ros.nodes.robot_contract import RobotContract
from omnipuck_sim.node.graph_pace import GraphPace
from omnipuck_sim.node.simulated_mocap import MOCAP_LIVE, SimulatedMocap

GROUPS = (Robot, Cap, Simulation, Limits, Control, Frames)


class SimulatorNode(Node):
    """Takes commands as the real robot does, but without a line that could be bad."""

    def __init__(self, **kwargs: object) -> None:
        super().__init__("simulator_node", **kwargs)
        declare(self, *GROUPS, live=(*LIVE, *MOCAP_LIVE), check=_check)
        settings = read_settings(self, *GROUPS)
        self._room = SimulatedMocap(self, settings)
        self._inputs = Inputs(self)
        self._pace = GraphPace(self, self._inputs, settings, self._room)
        times = self._pace.times if self._room.publishes_clock else None
        self._contract = RobotContract(self, self._inputs, self, settings, times)
        on_change(self, self._contract.change_settings, *GROUPS)
        self._constants = SharedConstants(self, settings, *GROUPS)
        self.create_service(Trigger, "reset", self._reset)
        self._room.start(self._pace.advance)
        self._diagnostics = Diagnostics(self, lambda: self._constants.judged(self._health()))
        self._inputs.ready(self._room.description)

    # ---- what the contract needs

    def now(self) -> float:
        """The simulated time, after the simulation was brought to the present [s]."""
        self._pace.advance()
        return self._room.simulator.time

    def is_ready(self) -> bool:
        """Always: there is no line between this node and the wheels."""
        return True

    def follow(self, velocity: np.ndarray, yaw_rate: float, age: float) -> None:
        """Commands the wheels from now on: velocity (2,) [m/s, robot frame] and yaw rate [rad/s] of this age [s]."""
        self._pace.advance()
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

    def _reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._pace.advance()
        self._room.simulator.reset()
        response.success, response.message = True, "back at the start, at rest"
        self.get_logger().info(f"reset: {response.message}")
        return response

    def _health(self) -> Health:
        contract, room = self._contract, self._room
        times = {"simulated_time": room.simulator.time, "time_stalled": room.stalled, **self._pace.values()}
        values = {**contract.counts, "impacts": room.impacts, **times}
        return contract.health(values, "", "simulated")


def _check(settings: Settings) -> None:
    """Raises ParameterError where values do not fit each other."""
    check_caps(settings)
    if settings.simulator.speed_factor == 0.0 and not settings.simulator.lockstep:
        raise ParameterError("simulator.speed_factor: got 0, expected more, or simulator.lockstep: true")


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable."""
    return run_node(SimulatorNode, args)
