"""The simulated robot in a hall, with motion capture, LIDAR and controller, in the test's own process."""

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped, TwistStamped
from sensor_msgs.msg import LaserScan

from collplan_core.worlds import save_world
from collplan_ros.messages.conversions import seconds_from_stamp
from collplan_ros.messages.qos import LATCHED, NEWEST, POSE_SUBSCRIBED, SENSOR_DATA
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.lidar_node import LidarNode
from collplan_ros.nodes.mocap_node import MocapNode
from fake_robot import hall
from omnipuck_sim.node.simulator_node import SimulatorNode

ONE_POSE = 0.01
"""Simulated time between two poses [s]."""
CLOCK = {"use_sim_time": True}
STAMPED = {**CLOCK, "controller.stamped_cmd_vel": True}


class SimulatedHall:
    """The graph without a planner, and what it says, in lockstep, as fast as the graph can."""

    def __init__(self, ros, folder, lidar=None, **simulation) -> None:
        """`lidar` makes what publishes `scan`, of its parameters; the rest are parameters `simulator.*`."""
        self.ros = ros
        world = folder / "hall.yaml"
        save_world(hall(), world)
        named = {f"simulator.{key}": value for key, value in simulation.items()}
        speed = {"simulator.world": str(world), "simulator.speed_factor": 0.0, "simulator.lockstep": True}
        self.simulator = ros.make(SimulatorNode, {**STAMPED, **speed, **named})
        ros.make(MocapNode, CLOCK)
        self.lidar = (lidar or self._true_lidar)({**CLOCK, "lidar.world": str(world)})
        self.controller = ros.make(ControllerNode, STAMPED)
        scans = ros.listen(LaserScan, "scan", SENSOR_DATA)
        self.poses = ros.listen(PoseStamped, "mocap/pose", POSE_SUBSCRIBED)
        self.commands = ros.listen(TwistStamped, "cmd_vel", NEWEST)
        self.states = ros.listen(DiagnosticStatus, "controller/state", LATCHED)
        assert ros.wait_until(lambda: self.poses and self.commands and scans)

    def _true_lidar(self, parameters) -> LidarNode:
        return self.ros.make(LidarNode, parameters)

    @property
    def now(self) -> float:
        """The newest pose's time [s, simulation]."""
        return seconds_from_stamp(self.poses[-1].header.stamp)

    @property
    def said(self) -> str:
        """What the controller said last of its state."""
        return self.states[-1].message if self.states else "no state"

    def until(self, condition, patience: float = 20.0) -> None:
        """Waits at most `patience` [s] on the simulation's clock."""
        assert self.ros.wait_until(condition, patience, lambda: self.now), self.said

    def pass_time(self, duration: float) -> None:
        """Lets so much simulated time pass [s]."""
        end = self.now + duration
        self.until(lambda: self.now >= end, duration + 1.0)

    @property
    def speed(self) -> float:
        """Of the newest command [m/s]."""
        return speed_of(self.commands[-1])


def speed_of(command: TwistStamped) -> float:
    """[m/s]"""
    linear = command.twist.linear
    return float(abs(linear.x) + abs(linear.y))
