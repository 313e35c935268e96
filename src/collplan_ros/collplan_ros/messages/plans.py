"""A plan as it is published: when to be where, and in messages of their own where it touches and how long it holds.

All three have the plan's stamp in their headers, which is how they are told to belong together. A plan is complete
without the other two. `reading` reads the first.
"""

import numpy as np
from geometry_msgs.msg import Quaternion, Transform, Twist
from nav_msgs.msg import Path
from sensor_msgs.msg import TimeReference
from std_msgs.msg import Header
from trajectory_msgs.msg import MultiDOFJointTrajectory, MultiDOFJointTrajectoryPoint

from collplan_core.plan import Contacts, Plan
from collplan_core.sensing.pose_filter import PoseSample
from collplan_ros.messages.conversions import (
    duration_from_seconds,
    header,
    pose_to_message,
    stamp_from_seconds,
    vector3,
)
from collplan_ros.messages.reading import MessageError, check_finite, check_frame, seconds_from_stamp

# ---- when to be where


def plan_to_path(plan: Plan, frame: str) -> Path:
    """Path of a plan's timed positions: its stamp is the plan's, the stamp of each pose the time to be there."""
    poses = [
        pose_to_message(PoseSample(float(time), position, 0.0), frame)
        for time, position in zip(plan.times, plan.positions, strict=True)
    ]
    return Path(header=header(plan.stamp, frame), poses=poses)


# ---- foreseen contacts


def contacts_to_message(contacts: Contacts, stamp: float, map_frame: str, base_frame: str) -> MultiDOFJointTrajectory:
    """Message of the contacts that the plan with this stamp [s] foresees, one point a contact, possibly none.

    In each, `transforms[0].translation` is where the ring touches, `velocities[0].linear` the velocity afterwards,
    both in the map frame, and `time_from_start` how long after the plan's stamp. The one joint is the base frame.
    """
    rows = zip(contacts.times, contacts.points, contacts.velocities_after, strict=True)
    points = [
        MultiDOFJointTrajectoryPoint(
            transforms=[Transform(translation=vector3(point), rotation=Quaternion(x=0.0, y=0.0, z=0.0, w=1.0))],
            velocities=[Twist(linear=vector3(velocity))],
            time_from_start=duration_from_seconds(float(time) - stamp),
        )
        for time, point, velocity in rows
    ]
    return MultiDOFJointTrajectory(header=header(stamp, map_frame), joint_names=[str(base_frame)], points=points)


def contacts_from_message(message: MultiDOFJointTrajectory, map_frame: str) -> tuple[float, Contacts]:
    """The stamp [s] of a plan and the contacts that it foresees, possibly none.

    Raises:
        MessageError: another frame, not one transform and one velocity a point, not finite, or times that are negative
            or fall.
    """
    check_frame("header.frame_id", message.header.frame_id, map_frame)
    stamp = seconds_from_stamp(message.header.stamp)
    rows = np.array([_contact(f"points[{number}]", point) for number, point in enumerate(message.points)])
    times, points, velocities = np.split(rows.reshape(-1, 5), (1, 3), axis=1)
    earliest = 0.0
    for number, time in enumerate(times[:, 0].tolist()):
        if time < earliest:
            raise MessageError(f"points[{number}].time_from_start: got {time:g} s, expected {earliest:g} s or more")
        earliest = time
    return stamp, Contacts(stamp + times[:, 0], points, velocities)


def _contact(field: str, point: MultiDOFJointTrajectoryPoint) -> list[float]:
    """Time from the plan's stamp [s], point touched x, y [m] and velocity afterwards vx, vy [m/s]."""
    for part, entries in (("transforms", point.transforms), ("velocities", point.velocities)):
        if len(entries) != 1:
            raise MessageError(f"{field}.{part}: got {len(entries)} entries, expected 1")
    at, after = point.transforms[0].translation, point.velocities[0].linear
    check_finite(f"{field}.transforms[0].translation", float(at.x), float(at.y))
    check_finite(f"{field}.velocities[0].linear", float(after.x), float(after.y))
    return [seconds_from_stamp(point.time_from_start), at.x, at.y, after.x, after.y]


# ---- until when


def validity_to_message(stamp: float, until: float, source: str) -> TimeReference:
    """Message of until when the plan with this stamp may be followed, both on the poses' clock [s].

    Args:
        source: full name of the node that says so.
    """
    return TimeReference(
        header=Header(stamp=stamp_from_seconds(stamp)), time_ref=stamp_from_seconds(until), source=str(source)
    )


def validity_from_message(message: TimeReference) -> tuple[float, float]:
    """The stamp of a plan and until when it may be followed, both on the poses' clock [s]; earlier than it is never."""
    return seconds_from_stamp(message.header.stamp), seconds_from_stamp(message.time_ref)
