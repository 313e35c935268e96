"""A plan as it is published: when to be where, and in messages of their own where it touches and how long it holds.

All three have the plan's stamp in their headers, which is how they are told to belong together. A plan is complete
without the other two. `reading` reads the first.
"""

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
from collplan_ros.messages.reading import seconds_from_stamp

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
