"""A plan as one message: a trajectory_msgs/MultiDOFJointTrajectory, in the bytes that DDS sends.

Each point has its time after the plan's stamp, and of each joint a transform and a velocity:

| joint | transform | velocity |
|---|---|---|
| `robot` | place of its centre | velocity |
| `contact` | point of the obstacle that the ring touches; NaN but at a contact | velocity after it |

The points are the path and the contacts in order of time. The last one is of neither: its time is how long the plan
holds, which may end before the path does. All have the same size, so that they are read and written as one array.
"""

from struct import Struct, error

import numpy as np

from collplan_core.plan import Contacts, Plan, plan_of_path
from collplan_core.validation import rising
from collplan_ros.messages.raw_reading import STAMP, START, aligned, read_header, read_text
from collplan_ros.messages.raw_writing import ENCODING, add_header, add_text, align
from collplan_ros.messages.reading import NANOSECONDS, MessageError

JOINTS = ROBOT, CONTACT = "robot", "contact"
MOST_JOINTS = 8
_COUNT = Struct("<I")


def _point(n_joints: int) -> np.dtype:
    """A point behind the number of its transforms, and that of the next one's, which the last point has not."""
    return np.dtype(
        [
            ("transforms", "<f8", (n_joints, 7)),
            ("n_velocities", "<u4"),
            ("padding", "<u4"),
            ("velocities", "<f8", (n_joints, 6)),
            ("n_accelerations", "<u4"),
            ("sec", "<i4"),
            ("nanosec", "<u4"),
            ("n_transforms", "<u4"),
        ]
    )


def plan_to_trajectory(plan: Plan, frame: str) -> bytes:
    """Returns the message of a plan, serialized; a plan without an end of validity holds to the end of its path.

    Args:
        plan: the plan.
        frame: the world frame.
    """
    contacts = plan.contacts
    until = plan.times[-1] if plan.valid_until is None else plan.valid_until
    others = np.append(contacts.times, until)
    times = np.append(plan.times, others)
    # in order of time, but for the last
    order = np.append(np.argsort(times[:-1], kind="stable"), len(times) - 1)
    rows = np.zeros(len(times), _point(len(JOINTS)))
    rows["n_transforms"] = rows["n_velocities"] = len(JOINTS)
    whole, rows["nanosec"] = np.divmod(_nanoseconds(times) - _nanoseconds(plan.stamp), NANOSECONDS)
    rows["sec"] = whole
    transforms, velocities = rows["transforms"], rows["velocities"]
    transforms[:, :, 6] = 1.0
    transforms[:, 0, :2] = np.vstack([plan.positions, _at(others, plan.times, plan.positions)])
    transforms[:, 1, :2] = np.nan
    transforms[len(plan.times) : -1, 1, :2] = contacts.points
    velocities[:, 0, :2] = np.vstack([plan.velocities, _at(others, plan.times, plan.velocities)])
    velocities[len(plan.times) : -1, 1, :2] = contacts.velocities_after
    raw = bytearray(ENCODING)
    add_header(raw, plan.stamp, frame.encode() + b"\0")
    align(raw, 4)
    raw += _COUNT.pack(len(JOINTS))
    for joint in JOINTS:
        add_text(raw, joint.encode() + b"\0")
    align(raw, 4)
    raw += _COUNT.pack(len(rows)) + _COUNT.pack(len(JOINTS))
    align(raw, 8)
    return bytes(raw + rows[order].tobytes()[: -_COUNT.size])


def plan_from_trajectory(raw: bytes, frame: str) -> Plan:
    """The plan in a serialized message; how it was chosen is not in it.

    Raises:
        MessageError: another frame, other joints, fewer than 2 points of the path, not finite, times of the path that
            do not rise, or bytes that are no such message.
    """
    try:
        _, at = read_header(raw, frame)
        sec, nanosec = STAMP.unpack_from(raw, START)
        joints, at = _joints(raw, at)
        rows = _points(raw, at, len(joints))
    except error as cut:
        raise MessageError(f"trajectory: got {len(raw)} bytes, {cut}") from None
    begin = sec * NANOSECONDS + nanosec
    after = rows["sec"].astype(np.int64) * NANOSECONDS + rows["nanosec"]
    whole, rest = np.divmod(begin + after, NANOSECONDS)
    times = whole + rest / NANOSECONDS
    robot, contact = joints.index(ROBOT), joints.index(CONTACT)
    touches = ~np.isnan(rows["transforms"][:, contact, 0])
    is_path = ~touches
    is_path[-1] = touches[-1] = False
    path_times = rising("points", times[is_path], MessageError)
    positions = np.ascontiguousarray(rows["transforms"][is_path, robot, :2])
    velocities = np.ascontiguousarray(rows["velocities"][is_path, robot, :2])
    points, rebounds = rows["transforms"][touches, contact, :2], rows["velocities"][touches, contact, :2]
    if not all(np.isfinite(each).all() for each in (positions, velocities, points, rebounds)):
        raise MessageError("points: got a position, velocity or contact that is not finite")
    contacts = Contacts(times[touches], points, rebounds)
    return plan_of_path(sec + nanosec / NANOSECONDS, path_times, positions, velocities, float(times[-1]), contacts)


def _joints(raw: bytes, at: int) -> tuple[list[str], int]:
    """Returns the joints that begin at an offset, those of earlier versions among them, and the offset behind them."""
    (count,) = _COUNT.unpack_from(raw, at := aligned(at, 4))
    at, names = at + _COUNT.size, []
    for _ in range(min(count, MOST_JOINTS)):
        name, at = read_text(raw, at)
        names.append(name)
    if not set(JOINTS) <= set(names):
        raise MessageError(f"joint_names: got {', '.join(names)}, expected {', '.join(JOINTS)}")
    return names, at


def _points(raw: bytes, at: int, n_joints: int) -> np.ndarray:
    """The points that begin at a place, one at least."""
    point = _point(n_joints)
    (count,) = _COUNT.unpack_from(raw, at := aligned(at, 4))
    begin = aligned(at + 2 * _COUNT.size, 8)
    if count < 1 or len(raw) < begin + count * point.itemsize - _COUNT.size:
        raise MessageError(
            f"points: got {count} in {len(raw)} bytes, expected {n_joints} transforms and velocities in each"
        )
    (first,) = _COUNT.unpack_from(raw, at + _COUNT.size)
    rows = np.frombuffer(raw + _COUNT.pack(n_joints), point, count, begin)
    if first != n_joints or not ((rows["n_velocities"] == n_joints) & (rows["n_accelerations"] == 0)).all():
        raise MessageError(f"points: expected {n_joints} transforms and velocities and no acceleration in each")
    return rows


def _nanoseconds(times: np.ndarray | float) -> np.ndarray:
    """Times as whole nanoseconds, rounded as those of a stamp."""
    whole = np.floor(times)
    return whole.astype(np.int64) * NANOSECONDS + np.rint((times - whole) * NANOSECONDS).astype(np.int64)


def _at(wanted: np.ndarray, times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (n, 2) at other times (m,) than theirs (n,); those at the ends beyond them."""
    return np.column_stack([np.interp(wanted, times, values[:, axis]) for axis in (0, 1)])
