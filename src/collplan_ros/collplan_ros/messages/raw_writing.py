"""Plans as the bytes that DDS sends: rclpy takes 1.5 ms to make and encode one of fifty poses, twenty a second."""

import math
from struct import Struct

from collplan_core.plan import Plan
from collplan_ros.messages.raw_reading import LITTLE_ENDIAN
from collplan_ros.messages.reading import NANOSECONDS

ENCODING = LITTLE_ENDIAN + bytes(2)
_COUNT = Struct("<I")
_STAMP_AND_LENGTH = Struct("<iII")
_POSE = Struct("<7d")


def plan_to_path(plan: Plan, frame: str) -> bytes:
    """A serialized nav_msgs/Path: its stamp is the plan's, the stamp of each pose the time to be there."""
    raw, name = bytearray(ENCODING), frame.encode() + b"\0"
    add_header(raw, plan.stamp, name)
    align(raw, 4)
    raw += _COUNT.pack(len(plan.times))
    for time, (x, y) in zip(plan.times.tolist(), plan.positions.tolist(), strict=True):
        add_header(raw, time, name)
        align(raw, 8)
        raw += _POSE.pack(x, y, 0.0, 0.0, 0.0, 0.0, 1.0)
    return bytes(raw)


def add_header(raw: bytearray, stamp: float, name: bytes) -> None:
    """Adds a std_msgs/Header: a stamp [s] and the name of a frame, with the zero at its end."""
    align(raw, 4)
    whole = math.floor(stamp)
    more, nanoseconds = divmod(round((stamp - whole) * NANOSECONDS), NANOSECONDS)
    raw += _STAMP_AND_LENGTH.pack(whole + more, nanoseconds, len(name)) + name


def align(raw: bytearray, size: int) -> None:
    """Fills up to where a value of this size may begin [bytes]."""
    raw += bytes((len(ENCODING) - len(raw)) % size)
