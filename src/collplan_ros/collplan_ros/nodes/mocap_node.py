"""Motion-capture poses in, odometry and impacts out; implausible poses are dropped and counted."""

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import TransformStamped, Vector3, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String

from collplan_core.ages import CLOCK, why_clock_is_wrong
from collplan_core.impact import Impact
from collplan_core.learning.drive import Drive, with_drive
from collplan_core.parameters import Frames, Limits, Mocap, Robot, Settings
from collplan_core.parameters.spec import ParameterError
from collplan_core.poses.localised import FrameInMap, moved_impact, moved_state
from collplan_core.poses.mocap_body import MeasuredPose, even_stamp, robot_pose
from collplan_core.poses.pose_filter import (
    FRESH,
    KIDNAPPED,
    FilterResult,
    PoseError,
    PoseSample,
    described_pose,
    filter_pose,
    warm_up,
)
from collplan_core.state import State
from collplan_ros.messages.conversions import impact_to_message, state_to_odometry
from collplan_ros.messages.mocap_formats import FORMATS, message_type
from collplan_ros.messages.planner_clouds import impact_to_cloud
from collplan_ros.messages.qos import EVENT, LATCHED, POSE_LISTENED, POSE_PUBLISHED, TRANSFORMS
from collplan_ros.messages.status_values import drive_from_message
from collplan_ros.node_kit.clock import described_age, seconds
from collplan_ros.node_kit.diagnostics import ERROR, WARN, Health
from collplan_ros.node_kit.graph_node import GraphNode
from collplan_ros.node_kit.inputs import EVENT as AN_EVENT
from collplan_ros.node_kit.inputs import Inputs
from collplan_ros.node_kit.run_node import run_node
from collplan_ros.nodes.localisation import Localisation
from collplan_ros.nodes.odometry_body import OdometryBody


def in_map(result: FilterResult, frame: FrameInMap) -> FilterResult:
    """A result of the filter in the frame of an odometry, moved to the map.

    The filter sees the odometry alone, so that a correction of the localisation is neither a leap nor an impact.
    """
    state = None if result.state is None else moved_state(result.state, frame)
    impact = None if result.impact is None else moved_impact(result.impact, frame)
    return result._replace(state=state, impact=impact)


def check_odometry(settings: Settings) -> None:
    """Checks that an odometry tied to the map has a frame, and does not count as lost while it slips.

    ParameterError: it has none, or does.
    """
    mocap, age = settings.mocap, settings.limits.pose_age
    if mocap.slip_time >= age:
        raise ParameterError(f"mocap.slip_time: got {mocap.slip_time:g}, expected less than limits.pose_age, {age:g} s")
    if mocap.localised and not mocap.frame:
        raise ParameterError("mocap.frame: got '', expected that of the odometry, as odom, with mocap.localised")


def frame_broadcast(node: Node) -> Callable[[Odometry], None]:
    """Makes the publisher of an odometry's pose as a transform on /tf; ParameterError: tf2_msgs is not installed."""
    try:
        from tf2_msgs.msg import TFMessage
    except ImportError:
        raise ParameterError("mocap.publish_tf: got True, expected False where tf2_msgs is not installed") from None
    publisher = node.create_publisher(TFMessage, "/tf", TRANSFORMS)

    def broadcast(odometry: Odometry) -> None:
        position = odometry.pose.pose.position
        message = TransformStamped(header=odometry.header, child_frame_id=odometry.child_frame_id)
        message.transform.translation = Vector3(x=position.x, y=position.y, z=position.z)
        message.transform.rotation = odometry.pose.pose.orientation
        publisher.publish(TFMessage(transforms=[message]))

    return broadcast


GROUPS = (Robot, Mocap, Limits, Frames)
LIVE = (Robot, Mocap, "limits.pose_age")
STAMPS_WITHOUT_STATE, STAMPS_WITH_STATE = 1.0, 2.0
"""Times between two comparisons of the stamps with the local clock [s]. A node that stood still is not such a clock."""
SAME_POSE = "nothing but the same pose (mocap.accept_frozen: false)"


class MocapNode(GraphNode):
    """Subscribes mocap.topic; publishes mocap/odom or mocap/refused for a pose, impact and impact/contact."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__("mocap_node", GROUPS, LIVE, check_odometry, **kwargs)
        self._memory = FRESH
        self._driving = self._settings
        self._drive: Drive | None = None
        self._newest: MeasuredPose | None = None
        self._repeats = 0
        self._longest_gap = 0.0
        self._even = math.nan
        self._compared = (math.nan, math.nan, 0)
        self._counts: Counter[str] = Counter()
        self._refused = self._reported = 0
        self._taken_at = -math.inf
        self._broadcast = frame_broadcast(self) if self._settings.mocap.publish_tf else None
        self._odometry = self.create_publisher(Odometry, "mocap/odom", POSE_PUBLISHED)
        self._refusal = self.create_publisher(String, "mocap/refused", EVENT)
        self._contact = self.create_publisher(PointCloud2, "impact/contact", EVENT)
        self._impact = self.create_publisher(Vector3Stamped, "impact", EVENT)
        mocap = self._settings.mocap
        self._read = FORMATS[mocap.format].read
        self._inputs = Inputs(self)
        ours = self._settings.frames.map
        self._localisation = Localisation(self._inputs, ours, mocap.frame, self._local) if mocap.localised else None
        self._body = OdometryBody(self, self._local) if mocap.format == "odometry" else None
        self._frame: FrameInMap | None = None
        self._slips_until = -math.inf
        self._inputs.listen(DiagnosticStatus, "controller/drive", self._take_drive, LATCHED, AN_EVENT)
        self._inputs.listen(message_type(mocap), mocap.topic, self._take, POSE_LISTENED[mocap.reliability])
        warm_up()
        self._begin(self._inputs)
        body = f", body {mocap.subject}" if mocap.subject else ""
        self._inputs.ready(f"format {mocap.format}{body}, frame {self._pose_frame()}")

    def _take(self, message: Any) -> bool:
        """Takes a message; returns whether it holds a pose of the robot's body."""
        self._counts["received"] += 1
        if self._body is not None:
            another = self._body.why_another(message.child_frame_id, self._settings)
            self._inputs.conflict(self._settings.mocap.topic, another and f"{self._settings.mocap.topic}: {another}")
        try:
            measured = self._read(message, self._settings.mocap.subject)
            if measured is not None:
                self._take_measured(measured)
        except PoseError as error:
            self._refuse(error.reason, str(error))
            return True
        return measured is not None

    def _take_drive(self, message: DiagnosticStatus) -> None:
        """Takes what the wheels can do: an impact is what they cannot."""
        self._drive = drive_from_message(message)
        self._driving = with_drive(self._settings, self._drive)

    def _change(self, settings: Settings) -> None:
        self._settings, self._driving = settings, with_drive(settings, self._drive)

    def _pose_frame(self) -> str:
        return self._settings.mocap.frame or self._settings.frames.map

    def _take_measured(self, measured: MeasuredPose) -> None:
        mocap, expected = self._settings.mocap, self._pose_frame()
        if measured.frame not in (None, expected):
            raise PoseError("frame", f"header.frame_id: got {measured.frame!r}, expected {expected!r}")
        now = seconds(self.get_clock())
        if mocap.rate > 0.0:
            self._even = even_stamp(self._even, now, 1.0 / mocap.rate)
            measured = replace(measured, stamp=self._even)
        sample = robot_pose(measured, now, mocap)
        # noise repeats no pose exactly: the body is lost and its last pose held, or the receiver outruns its cameras
        self._repeats = self._repeats + 1 if measured.repeats(self._newest) else 0
        self._newest = measured
        if self._repeats and not (mocap.accept_frozen or mocap.format == "odometry"):
            self._counts["repeated"] += 1
            if self._is_late():
                self._refuse("frozen", SAME_POSE)
            return
        self._take_sample(sample)

    def _take_sample(self, sample: PoseSample) -> None:
        received, before = self._local(), self._memory
        result, self._memory = filter_pose(before, sample, received, self._driving)
        if result.refused:
            self._refuse(result.refused, result.why)
            return
        if self._memory.track is before.track:
            self._counts["left_out"] += 1
            return
        self._taken_at = received
        if len(before.track.times):
            self._longest_gap = max(self._longest_gap, sample.stamp - float(before.track.times[-1]))
        self._watch_stamps(sample.stamp, received)
        if result.kidnapped:
            self._refusal.publish(String(data=f"{KIDNAPPED}: {described_pose(sample)}"))
        if self._localisation is not None:
            result = in_map(result, self._corrected(sample))
        self._publish(sample.stamp, result)

    def _corrected(self, sample: PoseSample) -> FrameInMap:
        """The odometry's frame in the map; reports a correction that is too large to be one."""
        assert self._localisation is not None, "only with one"
        before, self._frame = self._frame, self._localisation.known()
        if before is not None and before != self._frame:
            moved = float(np.hypot(*(self._frame.position(sample.position) - before.position(sample.position))))
            if moved > self._settings.mocap.largest_correction:
                limit = f"mocap.largest_correction {self._settings.mocap.largest_correction:g} m"
                self._refusal.publish(String(data=f"{KIDNAPPED}: the localisation moved it by {moved:.2f} m, {limit}"))
        return self._frame

    def _watch_stamps(self, stamp: float, received: float) -> None:
        """Reports stamps that do not run as time does."""
        stamp_then, received_then, published_then = self._compared
        elapsed, published = received - received_then, self._counts["published"]
        if elapsed < (STAMPS_WITHOUT_STATE if published == published_then else STAMPS_WITH_STATE):
            return
        self._compared = stamp, received, published
        if why := why_clock_is_wrong(stamp - stamp_then, elapsed):
            self._refuse(CLOCK, why)

    def _publish(self, stamp: float, result: FilterResult) -> None:
        self._counts["relocations"] += result.relocated
        if result.impact is not None:
            self._slips_until = stamp + self._settings.mocap.slip_time
            self._publish_impact(stamp, result.impact)
        if stamp < self._slips_until:
            self._counts["slipping"] += 1
        elif result.state is not None:
            self._publish_state(result.state, result)

    def _publish_impact(self, stamp: float, impact: Impact) -> None:
        """`impact` gets the stamp of the pose that shows the velocity after it, `impact/contact` its own time."""
        self._counts["impacts"] += 1
        frame = self._settings.frames.map
        self._contact.publish(impact_to_cloud(impact, frame))
        self._impact.publish(impact_to_message(stamp, impact.change, frame))

    def _publish_state(self, state: State, result: FilterResult) -> None:
        frames = self._settings.frames
        self._counts["published"] += 1
        self._longest_gap = 0.0
        message = state_to_odometry(state, frames.map, frames.base, result.yaw_rate, result.deviations)
        self._odometry.publish(message)
        if self._broadcast is not None:
            self._broadcast(message)

    def _refuse(self, reason: str, what: str) -> None:
        self._refused += 1
        self._refusal.publish(String(data=f"{reason}: {what}"))
        self._inputs.refused(self._settings.mocap.topic, f"{reason}: {what}", reason)

    def _age(self) -> float:
        """Local time since the newest pose was taken [s]."""
        return self._local() - self._taken_at

    def _is_late(self) -> bool:
        return self._age() > self._settings.limits.pose_age

    def _health(self) -> Health:
        age, refusals = self._age(), self._inputs.refusals
        new, self._reported = self._refused - self._reported, self._refused
        values = {**self._counts, "refused": self._refused, "age_s": age}
        missing = (
            f"on {self.resolve_topic_name(self._settings.mocap.topic)} {described_age(age)}" if self._is_late() else ""
        )
        is_slow = self._longest_gap > self._settings.limits.pose_age and age < 2.0 * self._longest_gap
        return Health.of(
            values,
            "poses come in",
            (ERROR, f"{SAME_POSE} {missing}" if self._repeats and missing else ""),
            (WARN, f"{new} poses refused, the last for {refusals.newest}" if new else ""),
            (WARN, self._too_slow() if is_slow else ""),
            (ERROR, missing and f"no pose {missing}"),
        )

    def _too_slow(self) -> str:
        """Returns why no pose is passed on: poses come too far apart to give a velocity."""
        limit = self._settings.limits.pose_age
        what = f"poses come {self._longest_gap:.2f} s apart, expected less than limits.pose_age {limit:g} s"
        if self._settings.mocap.format == "odometry":
            return what
        return f"{what}: of a localisation use the odometry beside it (mocap.format odometry, mocap.localised)"


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    return run_node(MocapNode, args)
