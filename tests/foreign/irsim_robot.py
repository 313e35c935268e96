"""Somebody else's robot, simulated by ir-sim: plain rclpy, not a line of collplan.

It takes /cmd_vel in its body frame and gives /odom with slip and drift, /tf, /tf_static and /scan. In a real robot the
localisation is another node. `python irsim_robot.py WORLD.yaml SEED [FAULT SECONDS]` runs it until it is ended.
"""

import math
import sys
from array import array

import irsim
import numpy as np
import rclpy
import shapely
from geometry_msgs.msg import TransformStamped, Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import LaserScan

from tf2_msgs.msg import TFMessage

STEP, LAG, ACCELERATION, WATCHDOG, RESTITUTION = 0.02, 0.1, 1.5, 0.5, 0.3
SCALE, SLIP = 1.01, 0.2
"""Error of the odometry, and the share of the change of velocity in a hit that it does not see."""
CORRECTION, SCAN = 0.2, 0.1
"""Periods of the localisation and of the LIDAR [s]."""
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class IrSimRobot(Node):
    def __init__(self, world: str, seed: int, fault: str = "", begins: float = math.inf) -> None:
        super().__init__("irsim_robot")
        self._env = irsim.make(world, display=False, disable_all_plot=True, log_level="ERROR")
        self._robot = self._env.robot
        self._walls = shapely.union_all([each.geometry for each in self._env.obstacle_list])
        self._random = np.random.default_rng(seed)
        self._fault, self._begins, self._steps = fault, begins, 0
        self._velocity, self._told, self._heard = np.zeros(2), np.zeros(2), -math.inf
        self._drift = self._robot.state[:2, 0].copy()
        self._odometry_at, self._unseen = np.zeros(2), np.zeros(2)
        self._odometry = self.create_publisher(Odometry, "/odom", 10)
        self._transforms = self.create_publisher(TFMessage, "/tf", 100)
        self._mount = self.create_publisher(TFMessage, "/tf_static", LATCHED)
        self._scans = self.create_publisher(LaserScan, "/scan", 5)
        self.touches = self.create_publisher(Twist, "/touches", 10)
        self.create_subscription(Twist, "/cmd_vel", self._take, 1)
        self._mount.publish(TFMessage(transforms=[self._transform("base_link", "laser", (0.0, 0.0))]))
        self.create_timer(STEP, self._step)

    def _is(self, fault: str) -> bool:
        return self._fault == fault and self._steps * STEP > self._begins

    def _take(self, twist: Twist) -> None:
        if self._is("deaf"):
            return
        sign = -1.0 if self._is("reversed") else 1.0
        self._told, self._heard = sign * np.array([twist.linear.x, twist.linear.y]), self._steps

    def _step(self) -> None:
        self._steps += 1
        told = self._told if STEP * (self._steps - self._heard) < WATCHDOG or self._is("deaf") else np.zeros(2)
        change = (told - self._velocity) * min(1.0, STEP / LAG)
        most = ACCELERATION * STEP
        change *= min(1.0, most / max(np.hypot(*change), 1e-9))
        self._velocity = self._velocity + change
        self._hit()
        self._env.step(self._velocity[:, None])
        seen = self._velocity - self._unseen
        self._unseen *= math.exp(-STEP / 0.05)
        self._odometry_at += SCALE * seen * STEP
        if not self._is("stopped"):
            self._tell(seen)

    def _hit(self) -> None:
        """Reflects the velocity from the nearest wall before the disc enters it: ir-sim would stop for good."""
        at = self._robot.state[:2, 0]
        point = shapely.Point(*(at + self._velocity * STEP))
        if self._walls.distance(point) > self._robot.radius:
            return
        nearest = shapely.get_coordinates(shapely.shortest_line(self._walls, shapely.Point(*at)))
        normal = (nearest[1] - nearest[0]) / max(np.hypot(*(nearest[1] - nearest[0])), 1e-9)
        into = float(self._velocity @ normal)
        if into < 0.0:
            change = -(1.0 + RESTITUTION) * into * normal
            self._velocity, self._unseen = self._velocity + change, self._unseen + SLIP * change
            self.touches.publish(Twist())

    def _tell(self, seen: np.ndarray) -> None:
        stamp = self.get_clock().now().to_msg()
        odometry = Odometry(child_frame_id="base_link")
        odometry.header.stamp, odometry.header.frame_id = stamp, "odom"
        odometry.pose.pose.position.x, odometry.pose.pose.position.y = map(float, self._odometry_at)
        odometry.twist.twist.linear.x, odometry.twist.twist.linear.y = map(float, seen)
        self._odometry.publish(odometry)
        if self._steps % round(CORRECTION / STEP) == 0:
            truth = self._robot.state[:2, 0] + self._random.normal(0.0, 0.005, 2)
            self._drift = truth - self._odometry_at
        tied = [self._transform("map", "odom", self._drift), self._transform("odom", "base_link", self._odometry_at)]
        self._transforms.publish(TFMessage(transforms=tied))
        if self._steps % round(SCAN / STEP) == 0:
            seen = self._env.get_lidar_scan()
            ranges = np.where(seen["ranges"] >= seen["range_max"] - 1e-3, np.inf, seen["ranges"])
            ends = {key: float(seen[key]) for key in ("angle_min", "angle_max", "range_min", "range_max")}
            scan = LaserScan(angle_increment=float(seen["angle_increment"]), **ends)
            scan.header.stamp, scan.header.frame_id = stamp, "laser"
            scan.ranges = array("f", ranges.astype(np.float32).tobytes())
            self._scans.publish(scan)

    def _transform(self, parent: str, child: str, at: np.ndarray | tuple[float, float]) -> TransformStamped:
        transform = TransformStamped(child_frame_id=child)
        transform.header.stamp, transform.header.frame_id = self.get_clock().now().to_msg(), parent
        transform.transform.translation.x, transform.transform.translation.y = map(float, at)
        return transform


if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(IrSimRobot(sys.argv[1], int(sys.argv[2]), *sys.argv[3:4], *map(float, sys.argv[4:5])))
