"""The simulated LIDAR: as in the paper (IV-A) rays cast from the measured pose, or a low-cost spinning sensor."""

from typing import Any

import numpy as np
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from visualization_msgs.msg import MarkerArray

from collplan_core.parameters import Frames, Lidar, Limits
from collplan_core.scan import Scan, ScanError
from collplan_core.state import State
from collplan_core.worlds import load_world, spinning_lidar
from collplan_core.worlds.instant_lidar import InstantLidar, MoverHistory
from collplan_core.worlds.spinning_lidar import SPINNING_SENSORS, sweeps_of
from collplan_ros.messages.conversions import scan_to_message
from collplan_ros.messages.qos import EVENT, POSE_SUBSCRIBED, SENSOR_PUBLISHED
from collplan_ros.messages.raw_reading import state_from_bytes
from collplan_ros.messages.reading import movers_from_markers
from collplan_ros.node_kit.clock import call_each_period, described_age
from collplan_ros.node_kit.diagnostics import ERROR, WARN, Health
from collplan_ros.node_kit.graph_node import GraphNode
from collplan_ros.node_kit.inputs import Inputs
from collplan_ros.node_kit.run_node import run_node

GROUPS = (Lidar, Limits, Frames)
LIVE = ("limits.pose_age",)


class LidarNode(GraphNode):
    """Subscribes mocap/odom and, where movers walk through the world, ground_truth/movers; publishes scan.

    The ideal sensor casts at lidar.rate from the newest pose, if fresh, and stamps the scan with it. Of a spinning one
    each beam is cast from between two poses, and the scan comes with the pose that shows that its latency is over.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__("lidar_node", GROUPS, LIVE, **kwargs)
        self._world = load_world(self._settings.lidar.world)
        self._state: State | None = None
        self._scanned: State | None = None
        self._scans = 0
        self._reported = 0
        self._frame = self._settings.lidar.frame or self._settings.frames.base
        self._publisher = self.create_publisher(LaserScan, "scan", SENSOR_PUBLISHED)
        self._inputs = Inputs(self)
        self._inputs.listen(Odometry, "mocap/odom", self._take_pose, POSE_SUBSCRIBED, kind="pose", raw=True)
        if self._world.movers:
            self._inputs.listen(MarkerArray, "ground_truth/movers", self._take_movers, EVENT, kind="movers")
        lidar = self._settings.lidar
        self._movers = MoverHistory()
        self._sweeps = sweeps_of(self._world, lidar, lidar.seed, self._movers)
        self._instant = InstantLidar(self._world, lidar, lidar.seed, self._movers)
        if self._sweeps is None:
            call_each_period(self, 1.0 / lidar.rate, self._scan, self._local_clock)
        self._warm_up()
        self._begin(self._inputs)
        sensor = SPINNING_SENSORS.get(lidar.sensor, lidar)
        self._inputs.ready(f"world {self._world.name}, {sensor.n_beams} beams at {sensor.rate:g} Hz")

    def _warm_up(self) -> None:
        """Compiles the ray casting, so that the first scan is not late."""
        if self._sweeps is not None:
            spinning_lidar.warm_up()
            return
        x_min, y_min, x_max, y_max = self._world.bounds
        middle = State(0.0, np.array([x_min + x_max, y_min + y_max]) / 2, np.zeros(2), 0.0)
        self._instant.scan(middle)

    def _take_pose(self, raw: bytes) -> None:
        frames = self._settings.frames
        self._state = state_from_bytes(raw, frames.map, frames.base)
        scan = None if self._sweeps is None else self._sweeps.take_pose(self._state)
        if scan is not None:
            self._publish(scan)

    def _take_movers(self, message: MarkerArray) -> None:
        stamp, movers = movers_from_markers(message, self._settings.frames.map)
        self._movers.add(stamp, movers[:, [0, 1, 4]])

    def _scan(self) -> None:
        state = self._state
        if state is None or state is self._scanned or self._pose_age() > self._settings.limits.pose_age:
            return
        self._scanned = state
        try:
            scan = self._instant.scan(state)
        except ScanError as error:
            self._inputs.refused("mocap/odom", str(error), "pose")
            return
        self._publish(scan)

    def _publish(self, scan: Scan) -> None:
        self._publisher.publish(scan_to_message(scan, self._frame))
        self._scans += 1

    def _pose_age(self) -> float:
        return self._inputs.age("mocap/odom")

    def _health(self) -> Health:
        age, refusals, topic = self._pose_age(), self._inputs.refusals, self.resolve_topic_name("mocap/odom")
        values = {"scans": self._scans, "world": self._world.name, "pose_age_s": age}
        new, self._reported = refusals["pose"] > self._reported, refusals["pose"]
        missing = f"no scan: no pose on {topic} {described_age(age)}" if age > self._settings.limits.pose_age else ""
        refused = f"pose refused: {refusals.newest}" if new else ""
        return Health.of(values, "scanning", (WARN, refused), (ERROR, missing))


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    return run_node(LidarNode, args)
