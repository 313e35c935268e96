"""QoS profiles of the project's topics."""

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy


def _profile(depth: int, reliable: bool = True, latched: bool = False) -> QoSProfile:
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


# mocap/pose, mocap/odom: published reliable so that any listener matches, subscribed best effort so that none is late.
# A recorder has lost what is no longer kept when it asks again, which can take the 3 s between two heartbeats of DDS
POSE_PUBLISHED = _profile(500)
POSE_SUBSCRIBED = _profile(10, reliable=False)
POSE_LISTENED = {"best_effort": POSE_SUBSCRIBED, "reliable": _profile(10)}
"""Profile of the subscription to a motion-capture receiver, by the value of mocap.reliability."""

# scan: subscribed best effort, as drivers may send them so; lidar_node's are reliable, and no recording lacks one
SENSOR_DATA = _profile(5, reliable=False)
SENSOR_PUBLISHED = _profile(100)

# events and what is recorded of each cycle, as goal_pose, impact, planner/costs, ground_truth/*: every one counts
EVENT = _profile(50)

# plan, cmd_vel, hand/cmd_vel: only the newest is acted on. Volatile: a latched plan would be a command to a node
# started later. Messages of planner and controller are kept a while for the recorder: a lost one is sent to it again
NEWEST = _profile(1)
NEWEST_PUBLISHED = _profile(50)

# states, as goal_status, robot/state, controller/state, planner/markers: a late listener gets the present one
LATCHED = _profile(1, latched=True)

# /tf and /tf_static: as tf2_ros publishes them
TRANSFORMS = _profile(100)
LATCHED_TRANSFORMS = _profile(100, latched=True)

# planner/journal, controller/journal: a recorder receives it from the node's first cycle on, even if discovered late
JOURNAL = _profile(200, latched=True)

# /diagnostics: latched, so that a late listener learns at once that a node is ready; many nodes share the topic
DIAGNOSTICS_PUBLISHED = LATCHED
DIAGNOSTICS_SUBSCRIBED = _profile(100, latched=True)

# shared_constants: each node latches its own; many nodes share the topic
CONSTANTS_PUBLISHED = LATCHED
CONSTANTS_SUBSCRIBED = DIAGNOSTICS_SUBSCRIBED

# for the page, which waits for nothing: every pose of a frame's time and of a short stall, and the newest of the rest
POSES_SHOWN = _profile(100, reliable=False)
COMMANDS_SHOWN = _profile(20, reliable=False)
NEWEST_SHOWN = _profile(1, reliable=False)

# for recorders: no message may be left out, so the queue bridges a stall of some seconds
EVERY_ONE = _profile(1000)
EVERY_LATCHED = _profile(1000, latched=True)
EVERY_UNRELIABLE = _profile(1000, reliable=False)
"""Also receives from reliable publishers."""
