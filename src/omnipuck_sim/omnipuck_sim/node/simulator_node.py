"""The simulated Omnipuck as a robot on the graph: takes cmd_vel, gives the poses of a motion capture and the truth."""

from collections.abc import Callable

import numpy as np
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node
from std_srvs.srv import Trigger

from collplan_core.control.arming import ARMED, WAITING, Arming
from collplan_core.parameters import Control, Frames, Limits, Robot, Simulation
from collplan_ros.messages.conversions import asks_for_rest
from collplan_ros.messages.qos import NEWEST
from collplan_ros.node_kit.diagnostics import OK, WARN, Diagnostics, Health
from collplan_ros.node_kit.node_parameters import declare, read_settings
from collplan_ros.node_kit.run_node import run_node
from collplan_ros.nodes.command_check import REFUSED, CommandCheck
from omnipuck_sim.node.mocap_room import MocapRoom

GROUPS = (Robot, Simulation, Limits, Control, Frames)


class SimulatorNode(Node):
    """Takes commands as the real robot does, but without a line that could be bad."""

    def __init__(self, **kwargs: object) -> None:
        super().__init__("simulator_node", **kwargs)
        declare(self, *GROUPS)
        self._settings = read_settings(self, *GROUPS)
        self._room = MocapRoom(self, self._settings)
        self._simulator = self._room.simulator
        self._estopped = False
        self._arming = ARMED
        self._check = CommandCheck(self._settings.robot, self._settings.limits)
        self._counts = {"commands": 0, "ignored": 0}
        self._make_inputs(stamped=self._settings.controller.stamped_cmd_vel)
        self._room.call_each_pose(self._room.advance)
        self._diagnostics = Diagnostics(self, self._health)

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
            self._room.advance()
            response.success, response.message = True, act()
            return response

        self.create_service(Trigger, name, answer)

    def _take_command(self, twist: Twist) -> None:
        self._room.advance()
        if self._estopped or self._waits_after(twist):
            self._counts["ignored"] += 1
            return
        self._counts["commands"] += 1
        self._simulator.command(*self._check.followed(twist))

    def _waits_after(self, twist: Twist) -> bool:
        silence = self._settings.limits.command_age
        self._arming = self._arming.after_command(asks_for_rest(twist), self._simulator.time, silence)
        return self._waits()

    def _waits(self) -> bool:
        return self._arming.is_waiting(self._simulator.time, self._settings.limits.command_age)

    def _reset(self) -> str:
        self._simulator.reset()
        return "back at the start, at rest"

    def _stop_latched(self) -> str:
        self._estopped = True
        self._simulator.command(np.zeros(2), 0.0)
        return "stopped; commands are ignored until clear_estop"

    def _clear_stop(self) -> str:
        if self._estopped:
            self._estopped, self._arming = False, Arming(self._simulator.time)
        return "commands are taken again after a zero command"

    def _health(self) -> Health:
        room = self._room
        times = {"simulated_time": self._simulator.time, "time_lost_in_stalls": room.lost}
        values = {**self._counts, **self._check.counts, "impacts": room.impacts, **times}
        if self._estopped:
            return Health(WARN, "emergency stop: commands are ignored", values)
        if self._waits():
            return Health(WARN, WAITING, values)
        if self._check.last_refused:
            return Health(WARN, REFUSED, values)
        return Health(OK, "simulated", values)


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable."""
    return run_node(SimulatorNode, args)
