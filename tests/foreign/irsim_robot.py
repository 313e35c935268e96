"""Somebody else's robot, simulated by ir-sim: plain rclpy, not a line of collplan.

It takes /cmd_vel in its body frame and gives /odom with slip and drift, /tf, /tf_static and /scan; in a real robot the
localisation is another node. `python irsim_robot.py WORLD.yaml SEED` runs it until it is ended. For tests it takes
/fault: silent, unlocalised, deaf, late or reversed; /truth is its true motion and, as angular.z, the number of touches.
Its frame is the fault that it has by then: a process that is held up takes one late.
"""

import math
import sys
from array import array

import irsim
import numpy as np
import rclpy
import shapely
from geometry_msgs.msg import TransformStamped, Twist, TwistWithCovariance, Vector3
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.time import Time
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String

from tf2_msgs.msg import TFMessage

STEP, LAG, ACCELERATION, WATCHDOG, RESTITUTION = 0.02, 0.1, 1.5, 0.5, 0.3
SCALE, SLIP = 1.01, 0.2
"""Error of the odometry, and the share of the change of velocity in a hit that it does not see."""
CORRECTION, SCAN, LATE = 0.2, 0.1, 15
"""Periods of the localisation and of the LIDAR [s], and the steps by which late commands are."""
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class IrSimRobot(Node):
    def __init__(self, world: str, seed: int) -> None:
        super().__init__("irsim_robot")
        self._env = irsim.make(world, display=False, disable_all_plot=True, log_level="ERROR")
        self._robot, self._random = self._env.robot, np.random.default_rng(seed)
        self._walls = shapely.union_all([each.geometry for each in self._env.obstacle_list])
        self._begun = self.get_clock().now()
        self._fault, self._steps, self._touches, self._commands = "", 0, 0, [(0, np.zeros(2))]
        self._velocity, self._heard, self._drift = np.zeros(2), -math.inf, self._robot.state[:2, 0].copy()
        self._odometry_at, self._unseen = np.zeros(2), np.zeros(2)
        self._odometry = self.create_publisher(Odometry, "/odom", 10)
        self._transforms = self.create_publisher(TFMessage, "/tf", 100)
        mount = self.create_publisher(TFMessage, "/tf_static", LATCHED)
        self._scans = self.create_publisher(LaserScan, "/scan", 5)
        self._truth = self.create_publisher(Odometry, "/truth", 10)
        self.create_subscription(String, "/fault", lambda message: setattr(self, "_fault", message.data), 10)
        self.create_subscription(Twist, "/cmd_vel", self._take, 1)
        mount.publish(TFMessage(transforms=[self._transform("base_link", "laser", *self._robot.lidar.offset.ravel())]))
        self.create_timer(STEP, self._go_on)

    def _take(self, twist: Twist) -> None:
        if self._fault == "deaf":
            return
        sign, wait = -1.0 if self._fault == "reversed" else 1.0, LATE if self._fault == "late" else 0
        self._commands.append((self._steps + wait, sign * np.array([twist.linear.x, twist.linear.y])))
        self._heard = self._steps

    @property
    def _time(self) -> Time:
        return self._begun + Duration(seconds=STEP * self._steps)

    def _go_on(self) -> None:
        """Wheels turn in real time, also while their driver's process has to wait."""
        while self._time < self.get_clock().now():
            self._step()

    def _step(self) -> None:
        self._steps += 1
        while len(self._commands) > 1 and self._commands[1][0] <= self._steps:
            del self._commands[0]
        obeys = self._fault == "deaf" or STEP * (self._steps - self._heard) < WATCHDOG
        told = self._commands[0][1] if obeys else np.zeros(2)
        change = (told - self._velocity) * min(1.0, STEP / LAG)
        self._velocity = self._velocity + change * min(1.0, ACCELERATION * STEP / max(np.hypot(*change), 1e-9))
        self._hit()
        self._env.step(self._velocity[:, None])
        seen = self._velocity - self._unseen
        self._unseen *= math.exp(-STEP / 0.05)
        self._odometry_at += SCALE * seen * STEP
        truth = Odometry(twist=self._twist(self._velocity, float(self._touches)))
        truth.header.frame_id = self._fault
        truth.pose.pose.position.x, truth.pose.pose.position.y = self._robot.state[:2, 0].tolist()
        self._truth.publish(truth)
        if self._fault != "silent":
            self._tell(seen)

    def _hit(self) -> None:
        """Reflects the velocity from the nearest wall before the disc enters it: ir-sim would stop for good."""
        at = self._robot.state[:2, 0]
        point = shapely.Point(*(at + self._velocity * STEP))
        if self._walls.distance(point) > self._robot.radius:
            return
        nearest = shapely.get_coordinates(shapely.shortest_line(self._walls, shapely.Point(*at)))
        normal = (nearest[1] - nearest[0]) / max(np.hypot(*(nearest[1] - nearest[0])), 1e-9)
        if (into := float(self._velocity @ normal)) < 0.0:
            change = -(1.0 + RESTITUTION) * into * normal
            self._velocity, self._unseen = self._velocity + change, self._unseen + SLIP * change
            self._touches += 1

    def _tell(self, seen: np.ndarray) -> None:
        stamp = self._time.to_msg()
        odometry = Odometry(child_frame_id="base_link", twist=self._twist(seen))
        odometry.header.stamp, odometry.header.frame_id = stamp, "odom"
        odometry.pose.pose.position.x, odometry.pose.pose.position.y = self._odometry_at.tolist()
        self._odometry.publish(odometry)
        if self._steps % round(CORRECTION / STEP) == 0:
            self._drift = self._robot.state[:2, 0] + self._random.normal(0.0, 0.005, 2) - self._odometry_at
        tied = [self._transform("odom", "base_link", *self._odometry_at)]
        if self._fault != "unlocalised":
            tied.append(self._transform("map", "odom", *self._drift))
        self._transforms.publish(TFMessage(transforms=tied))
        if self._steps % round(SCAN / STEP) == 0:
            seen = self._env.get_lidar_scan()
            ranges = np.where(seen["ranges"] >= seen["range_max"] - 1e-3, np.inf, seen["ranges"])
            ends = {key: float(seen[key]) for key in ("angle_min", "angle_max", "range_min", "range_max")}
            scan = LaserScan(angle_increment=float(seen["angle_increment"]), **ends)
            scan.header.stamp, scan.header.frame_id = stamp, "laser"
            scan.ranges = array("f", ranges.astype(np.float32).tobytes())
            self._scans.publish(scan)

    def _twist(self, velocity: np.ndarray, turn: float = 0.0) -> TwistWithCovariance:
        x, y = velocity.tolist()
        return TwistWithCovariance(twist=Twist(linear=Vector3(x=x, y=y), angular=Vector3(z=turn)))

    def _transform(self, parent: str, child: str, x: float, y: float, yaw: float = 0.0) -> TransformStamped:
        transform = TransformStamped(child_frame_id=child)
        transform.transform.rotation.z, transform.transform.rotation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        transform.header.stamp, transform.header.frame_id = self._time.to_msg(), parent
        transform.transform.translation.x, transform.transform.translation.y = float(x), float(y)
        return transform


if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(IrSimRobot(sys.argv[1], int(sys.argv[2])))
