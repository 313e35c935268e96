"""The whole loop in this process, in simulated time that waits for it."""

from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry, Path
from rclpy.serialization import serialize_message
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String

from collplan_core.state import State
from collplan_ros.messages.conversions import goal_to_message
from collplan_ros.messages.qos import EVENT, LATCHED, NEWEST, POSE_SUBSCRIBED, SENSOR_DATA
from collplan_ros.messages.raw_reading import state_from_bytes
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.lidar_node import LidarNode
from collplan_ros.nodes.mocap_node import MocapNode
from collplan_ros.nodes.planner_node import PlannerNode
from omnipuck_sim.node.simulator_node import SimulatorNode


class Graph:
    """The whole loop in a world that simulator and lidar alone are told."""

    def __init__(self, ros, world: str, transforms: bool = False, **parameters) -> None:
        self.ros = ros
        clock = {"use_sim_time": True}
        shared = {**clock, **{key.replace("__", "."): value for key, value in parameters.items()}}
        simulation = {"simulator.world": world, "simulator.seed": 3, "simulator.speed_factor": 0.0}
        self.odometry = ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
        self.commands = ros.listen(Twist, "cmd_vel", NEWEST)
        self.plans = ros.listen(Path, "plan", NEWEST)
        self.maneuvers = ros.listen(String, "maneuver", LATCHED)
        self.statuses = ros.listen(GoalStatus, "goal_status", LATCHED)
        ros.make(SimulatorNode, {**clock, **simulation})
        ros.make(MocapNode, {**clock, "mocap.publish_tf": transforms})
        ros.make(LidarNode, {**clock, "lidar.world": world})
        self.planner = ros.make(PlannerNode, shared)
        # all nodes share a thread here, and poses wait in its queues
        ros.make(ControllerNode, {**shared, "limits.motion_delay": 0.4})
        self.goals = ros.publisher(PoseStamped, "goal_pose", EVENT)
        scans = ros.listen(LaserScan, "scan", SENSOR_DATA)
        # only once it hears of goals is one new to the robot, and lets it move
        assert ros.wait_until(lambda: len(scans) > 5 and ros.probe.count_subscribers("goal_status") >= 3)

    def send_goal(self, goal) -> None:
        self.goals.publish(goal_to_message(goal, "map"))

    @property
    def state(self) -> State:
        return state_from_bytes(serialize_message(self.odometry[-1]), "map", "base_link")

    @property
    def status(self) -> int | None:
        return self.statuses[-1].status if self.statuses else None
