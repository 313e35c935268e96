"""The frame of an odometry in the map, by the newest transform that a localisation broadcasts; without tf2_ros."""

import math
from collections.abc import Callable
from typing import Any

from collplan_core.parameters.spec import ParameterError
from collplan_core.poses.localised import FrameInMap
from collplan_core.poses.pose_filter import PoseError, check_pose_fields
from collplan_ros.messages.qos import LATCHED_TRANSFORMS, TRANSFORMS
from collplan_ros.messages.reading import MessageError, place_fields, seconds_from_stamp
from collplan_ros.node_kit.clock import described_age
from collplan_ros.node_kit.inputs import EVENT, Inputs

UNLOCALISED = "unlocalised"
"""Reason of a pose that is refused because its frame is not known in the map yet, or not any more."""
TOLERANCE = 1e-3
"""Largest deviation of a quaternion's norm from 1."""
LONGEST_SILENCE = 1.0
"""Largest age of the newest transform on /tf [s]: localisations send one with every scan, or oftener."""


class Localisation:
    """Listens on /tf and /tf_static for the transform from one frame to another."""

    def __init__(self, inputs: Inputs, parent: str, child: str, local: Callable[[], float]) -> None:
        """Subscribes through `inputs`, ages by `local` [s]; ParameterError: tf2_msgs is not installed."""
        try:
            from tf2_msgs.msg import TFMessage
        except ImportError:
            raise ParameterError("mocap.localised: got True, expected False where tf2_msgs is not installed") from None
        self.frame: FrameInMap | None = None  # pose of the child in the parent; None before the first transform
        self._parent, self._child, self._local = parent, child, local
        self._received = -math.inf
        self._inputs = inputs
        self._dynamic = self._static = False
        inputs.listen(TFMessage, "/tf", lambda message: self._take(message, local()), TRANSFORMS, EVENT)
        inputs.listen(TFMessage, "/tf_static", lambda message: self._take(message, math.inf), LATCHED_TRANSFORMS, EVENT)

    def _take(self, message: Any, received: float) -> None:
        for each in message.transforms:
            if (each.header.frame_id, each.child_frame_id) != (self._parent, self._child):
                continue
            self._note_sender(math.isinf(received))
            position, quaternion = place_fields(each.transform.translation, each.transform.rotation)
            try:
                pose = check_pose_fields(seconds_from_stamp(each.header.stamp), position, quaternion, TOLERANCE)
            except PoseError as error:
                raise MessageError(f"transform from {self._parent} to {self._child}: {error}") from None
            x, y = pose.position.tolist()
            self.frame, self._received = FrameInMap(x, y, pose.yaw), received

    def _note_sender(self, is_static: bool) -> None:
        """Notes that the present message holds the transform, of which one node alone may be the source."""
        self._static, self._dynamic = self._static or is_static, self._dynamic or not is_static
        if not is_static:
            self._inputs.count_sender("/tf")
        if self._static and self._dynamic:
            named = [f"{on} ({', '.join(dict.fromkeys(self._inputs.publishers(on)))})" for on in ("/tf", "/tf_static")]
            what = f"the transform from {self._parent} to {self._child} comes on {' and '.join(named)}"
            self._inputs.conflict("/tf_static", f"{what}, the newest is taken; expected one source: end one")

    def known(self) -> FrameInMap:
        """The pose of the child in the parent; PoseError: there was no transform yet, or none for LONGEST_SILENCE."""
        age = self._local() - self._received
        if self.frame is None or age > LONGEST_SILENCE:
            missing = f"no transform from {self._parent} to {self._child} on /tf {described_age(age)}"
            raise PoseError(UNLOCALISED, f"{missing}: does a localisation run?")
        return self.frame
