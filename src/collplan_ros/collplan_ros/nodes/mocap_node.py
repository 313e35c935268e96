"""Motion-capture poses in, odometry and impacts out; implausible poses are dropped and counted."""

from collections import Counter
from typing import Any

from geometry_msgs.msg import Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.node import Node

from collplan_core.parameters import Frames, Limits, Mocap, Robot, Settings
from collplan_core.sensing.mocap_body import MeasuredPose, robot_pose
from collplan_core.sensing.pose_filter import FRESH, FilterResult, PoseError, PoseSample, filter_pose, warm_up
from collplan_core.state import State
from collplan_ros.messages.conversions import impact_to_message, state_to_odometry
from collplan_ros.messages.mocap_formats import FORMATS, message_type
from collplan_ros.messages.qos import EVENT, POSE_LISTENED, POSE_PUBLISHED
from collplan_ros.node_kit.clock import PosesClock, described_age, local_clock, seconds
from collplan_ros.node_kit.diagnostics import ERROR, OK, WARN, Diagnostics, Health
from collplan_ros.node_kit.node_parameters import declare, on_change, read_settings
from collplan_ros.node_kit.run_node import run_node
from collplan_ros.nodes.frame_broadcast import frame_broadcast

GROUPS = (Robot, Mocap, Limits, Frames)


class MocapNode(Node):
    """Subscribes mocap.topic; publishes at most one mocap/odom per pose, and impact when one is detected."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__("mocap_node", **kwargs)
        declare(self, *GROUPS)
        self._settings = read_settings(self, *GROUPS)
        on_change(self, self._change, *GROUPS)
        self._memory = FRESH
        self._newest: MeasuredPose | None = None
        self._repeats = 0
        self._counts: Counter[str] = Counter()
        self._reported = 0
        self._last_refusal = ""
        self._local = local_clock(self)
        self._poses_clock = PosesClock()
        self._broadcast = frame_broadcast(self) if self._settings.mocap.publish_tf else None
        self._odometry = self.create_publisher(Odometry, "mocap/odom", POSE_PUBLISHED)
        self._impact = self.create_publisher(Vector3Stamped, "impact", EVENT)
        mocap = self._settings.mocap
        self._read = FORMATS[mocap.format].read
        self.create_subscription(message_type(mocap), mocap.topic, self._take, POSE_LISTENED[mocap.reliability])
        warm_up()
        self._diagnostics = Diagnostics(self, self._health)

    def _change(self, settings: Settings) -> None:
        self._settings = settings

    def _take(self, message: Any) -> None:
        self._counts["received"] += 1
        try:
            measured = self._read(message, self._settings.mocap.subject)
            if measured is not None:
                self._take_measured(measured)
        except PoseError as error:
            self._count_refused(error.reason, str(error))

    def _take_measured(self, measured: MeasuredPose) -> None:
        mocap, expected = self._settings.mocap, self._settings.mocap.frame or self._settings.frames.map
        if measured.frame not in (None, expected):
            raise PoseError("frame", f"header.frame_id: got {measured.frame!r}, expected {expected!r}")
        sample = robot_pose(measured, seconds(self.get_clock()), mocap)
        # noise repeats no pose exactly: the body is lost and its last pose held, or the receiver outruns its cameras
        self._repeats = self._repeats + 1 if measured.repeats(self._newest) else 0
        self._newest = measured
        if self._repeats and not mocap.accept_frozen:
            self._counts["repeated"] += 1
            return
        self._take_sample(sample)

    def _take_sample(self, sample: PoseSample) -> None:
        received = seconds(self._local)
        result, self._memory = filter_pose(self._memory, sample, received, self._settings)
        if result.refused:
            self._count_refused(result.refused, f"pose {sample.position.tolist()} at {sample.stamp:.3f}")
            return
        self._poses_clock.received(sample.stamp, received)
        self._publish(sample.stamp, result)

    def _publish(self, stamp: float, result: FilterResult) -> None:
        self._counts["relocations"] += result.relocated
        if result.impact is not None:
            self._counts["impacts"] += 1
            self._impact.publish(impact_to_message(stamp, result.impact, self._settings.frames.map))
        if result.state is not None:
            self._publish_state(result.state)

    def _publish_state(self, state: State) -> None:
        frames = self._settings.frames
        self._counts["published"] += 1
        message = state_to_odometry(state, frames.map, frames.base)
        self._odometry.publish(message)
        if self._broadcast is not None:
            self._broadcast(message)

    def _count_refused(self, reason: str, what: str) -> None:
        self._counts[f"refused_{reason}"] += 1
        self._last_refusal = f"{reason}: {what}"
        self.get_logger().warning(f"refused, {self._last_refusal}", throttle_duration_sec=1.0)

    def _health(self) -> Health:
        age = self._poses_clock.age(seconds(self._local))
        refused = sum(count for key, count in self._counts.items() if key.startswith("refused_"))
        new, self._reported = refused - self._reported, refused
        values = {**self._counts, "refused": refused, "age_s": age}
        if new:
            return Health(WARN, f"{new} poses refused, the last for {self._last_refusal}", values)
        if age > self._settings.limits.pose_age:
            return Health(ERROR, f"{self._missing()} {described_age(age)}", values)
        return Health(OK, "poses come in", values)

    def _missing(self) -> str:
        topic = self.resolve_topic_name(self._settings.mocap.topic)
        if self._repeats:
            return f"nothing but the same pose on {topic} (mocap.accept_frozen: false)"
        return f"no pose on {topic}"


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    return run_node(MocapNode, args)
