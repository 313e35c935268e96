"""States and plans read out of the bytes that DDS delivers, and plans as such bytes.

rclpy makes a Python object of every part of a message: 190 us for a state, of which five nodes take 100 a second, and
3 ms for a plan of fifty poses; this takes a ninth of that, and a tenth; 1.5 ms to encode such a plan. The bytes are
the same numbers in CDR, the encoding of DDS (OMG XTYPES 1.3, 7.4.3, version 1): each value aligned to its size, counted
from the end of a header of four bytes.
"""

import math
from struct import Struct, error

import numpy as np

from collplan_core.plan import Plan, plan_of_path
from collplan_core.plane import rotate
from collplan_core.state import State
from collplan_core.validation import finite, rising
from collplan_ros.messages.reading import NANOSECONDS, MessageError, check_finite, check_frame, yaw_of

BYTES_TOPICS = ("mocap/odom", "ground_truth/odom", "plan")
"""Topics whose messages are taken as bytes."""
LITTLE_ENDIAN = b"\x00\x01"
START = 4
ENCODING = LITTLE_ENDIAN + bytes(2)
_COUNT = Struct("<I")
STAMP = Struct("<iI")
_STAMP_AND_LENGTH = Struct("<iII")
_POINT = Struct("<dd")
_POSE = Struct("<7d")
_TWIST = Struct("<6d")
_COVARIANCE = 36 * 8


def plan_from_path(raw: bytes, frame: str) -> Plan:
    """The plan in a serialized nav_msgs/Path: times and positions alone.

    MessageError: another frame, fewer than 2 poses, not finite, times that do not rise, or bytes that are no path.
    """
    try:
        stamp, at = read_header(raw, frame)
        (count,) = _COUNT.unpack_from(raw, at := aligned(at, 4))
        at += 4
        if count > len(raw):
            raise MessageError(f"poses: got {count} in {len(raw)} bytes")
        rows = np.empty((count, 3))
        for k in range(count):
            sec, nanosec, length = _STAMP_AND_LENGTH.unpack_from(raw, at := aligned(at, 4))
            at = aligned(at + 12 + length, 8)
            rows[k, 0] = sec + nanosec / NANOSECONDS
            rows[k, 1:] = _POINT.unpack_from(raw, at)
            at += _POSE.size
    except error as cut:
        raise MessageError(f"path: got {len(raw)} bytes, {cut}") from None
    times = rising("poses", rows[:, 0], MessageError)
    positions = finite("poses", rows[:, 1:], (None, 2), "expected finite numbers", MessageError)
    return plan_of_path(stamp, times, positions, None)


def state_from_bytes(raw: bytes, map_frame: str, base_frame: str) -> State:
    """The state in a serialized nav_msgs/Odometry, in the map frame.

    MessageError: other frames, not finite, not a unit quaternion, or bytes that are no odometry.
    """
    try:
        stamp, at = read_header(raw, map_frame)
        child, at = read_text(raw, at)
        check_frame("child_frame_id", child, base_frame)
        x, y, _, qx, qy, qz, qw = _POSE.unpack_from(raw, at := aligned(at, 8))
        vx, vy, *_ = _TWIST.unpack_from(raw, at + _POSE.size + _COVARIANCE)
    except error as cut:
        raise MessageError(f"odometry: got {len(raw)} bytes, {cut}") from None
    check_finite("pose.position", x, y)
    check_finite("twist.linear", vx, vy)
    yaw = yaw_of(qx, qy, qz, qw)
    return State(stamp, np.array([x, y]), np.array(rotate(vx, vy, yaw)), yaw)


def read_header(raw: bytes, frame: str) -> tuple[float, int]:
    """Returns the stamp [s] of a std_msgs/Header at the beginning, and the offset of its end; its frame is checked."""
    if raw[:2] != LITTLE_ENDIAN:
        raise MessageError(f"encoding: got {raw[:2].hex()}, expected {LITTLE_ENDIAN.hex()}, CDR in little endian")
    sec, nanosec = STAMP.unpack_from(raw, START)
    got, at = read_text(raw, START + STAMP.size)
    check_frame("header.frame_id", got, frame)
    return sec + nanosec / NANOSECONDS, at


def read_text(raw: bytes, at: int) -> tuple[str, int]:
    """Returns the string at an offset, and the offset of its end."""
    (length,) = _COUNT.unpack_from(raw, at := aligned(at, 4))
    return raw[at + 4 : at + 3 + length].decode(errors="replace"), at + 4 + length


def aligned(at: int, size: int) -> int:
    """The next place from `at` on for a value of this size [bytes]."""
    return at + (START - at) % size


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
