"""Every parameter of the project, each written once. Starting values that the paper does not print are assumed.

A key is `group.field`, for example `planner.map_period`; no two groups share a key, so one flat name space serves
parameter files, `ros2 param set` and the study's grid.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from math import pi, radians, sqrt
from typing import Any

from collplan_core.fence import why_no_polygon
from collplan_core.parameters.spec import ParameterError, Parameters, Spec, parameter, specs
from collplan_core.strategies import NAMES
from collplan_core.yaml_text import YamlError, parse_yaml

_PART = r"(?:[A-Za-z_]|\{(?:node|ns|namespace)\})(?:\w|\{(?:node|ns|namespace)\})*"
TOPIC = re.compile(rf"~|(?:~?/)?{_PART}(?:/{_PART})*", re.ASCII)
"""Names of topics that ROS accepts: design.ros2.org, Topic and Service Names."""
A_TOPIC = "expected a name of ROS: letters, digits, _ and /; no part begins with a digit or is empty"
RADIUS = 0.09
"""Radius of the Omnipuck [m]."""
LONGEST_TOPIC = 247
"""Characters of a topic's name that the middleware accepts."""


def check_topic(key: str, topic: str) -> None:
    """Raises ParameterError where the value of a key is no name of a topic."""
    if not TOPIC.fullmatch(topic) or len(topic) > LONGEST_TOPIC:
        raise ParameterError(f"{key}: got {topic!r}, {A_TOPIC}")


@dataclass(frozen=True)
class Robot(Parameters):
    """The Omnipuck. All assumed but max_speed (paper, IV-B)."""

    group = "robot"
    radius: float = parameter(RADIUS, "Radius of the body with its reflection ring (assumed)", unit="m", low=0.01, high=1.0)
    mass: float = parameter(0.7, "Mass (assumed)", unit="kg", low=0.05, high=100.0)
    inertia_factor: float = parameter(1.0 / 3.0, "1 / (1 + m r^2 / I): 1/3 for a uniform disc, 1/2 with all mass in the ring (assumed)", low=0.05, high=0.5)
    wheel_mass: float = parameter(0.0, "Reflected mass of wheels and motors: a hit stops the body alone, traction then pulls the two together (assumed)", unit="kg", low=0.0, high=10.0)
    max_speed: float = parameter(1.2, "Largest speed commanded or planned, v_max (paper)", unit="m/s", low=0.05, high=5.0, live=True)
    velocity_shape: str = parameter("disc", "max_speed limits the length of the velocity (disc), or each axis of the body frame on its own (box), as many mecanum bases do", choices=("disc", "box"))
    max_yaw_rate: float = parameter(3.0, "Largest yaw rate that the robot accepts (assumed)", unit="rad/s", low=0.1, high=20.0)
    max_acceleration: float = parameter(1.5, "Largest acceleration the wheels can make (assumed)", unit="m/s^2", low=0.1, high=20.0)
    velocity_lag: float = parameter(0.1, "Time constant of the velocity loop (assumed)", unit="s", low=0.0, high=1.0)
    motion_delay: float = parameter(0.0, "Delay from a pose's stamp until the wheels act on it: motion capture, transport and firmware, without velocity_lag", unit="s", low=0.0, high=0.3)
    learning: str = parameter("drive", "Learn max_acceleration, velocity_lag and motion_delay while driving (drive), beginning with these; controller/drive tells them", choices=("off", "drive"))

    @property
    def fastest(self) -> float:
        """Largest speed in any direction: max_speed, along the diagonals of a box sqrt 2 times that [m/s]."""
        return self.max_speed * (sqrt(2.0) if self.velocity_shape == "box" else 1.0)


@dataclass(frozen=True)
class Rebound(Parameters):
    """The planner's model of a rebound. The simulator has values of its own."""

    group = "rebound"
    restitution: float = parameter(0.7, "Share of the speed into the wall that is returned (assumed)", low=0.0, high=1.0, live=True)
    friction: float = parameter(0.12, "Coulomb friction of ring and wall (assumed)", low=0.0, high=5.0, live=True)


@dataclass(frozen=True)
class LocalMapping(Parameters):
    """The sliding local map that is made of a scan."""

    group = "local_map"
    half_side: float = parameter(0.6, "Half the side of the square map around the robot; time-to-goal strategies use time_to_goal.half_side", unit="m", low=0.2, high=5.0, live=True, of_radius=RADIUS)
    n_rays: int = parameter(360, "Directions in which the free space is measured, evenly over the full turn; a multiple of 4", low=60, high=3600)
    predicted: str = parameter("going_on", "Set E: where an observed boundary is seen to continue (going_on), or wherever one meets a frontier (printed)", choices=("going_on", "printed"), live=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.n_rays % 4:
            raise ParameterError(f"local_map.n_rays: got {self.n_rays}, expected a multiple of 4, so that quarter turns change nothing")


@dataclass(frozen=True)
class Weights(Parameters):
    """Weights of the objective, used when planner.strategy is custom."""

    group = "weights"
    position: float = parameter(100.0, "w_p, weight of J_pos", low=0.0, high=1e6, live=True)
    risk: float = parameter(0.1, "w_r, weight of J_risk", low=0.0, high=1e6, live=True)
    velocity: float = parameter(4.0, "w_v, weight of J_vel", low=0.0, high=1e6, live=True)


SHORTEST_MAP_PERIOD = 0.05


@dataclass(frozen=True)
class Planning(Parameters):
    """The sampling planner (paper, II and III-A). Readings name how a passage of the paper is understood; `printed` is the passage to the letter."""

    group = "planner"
    strategy: str = parameter("harness", "Weight sets of the paper (custom: the weights group), or time-to-goal strategies, which differ in how they treat contacts", choices=NAMES, live=True)
    map_period: float = parameter(0.0, "T_map, time between two plans, at least 0.05; 0 is the strategy's own: 0.2 for the paper's, 0.05 for the others", unit="s", low=0.0, high=2.0, live=True)
    journal: bool = parameter(True, "Planner and controller publish their inputs and decisions, from which replay repeats a run")
    goal_tolerance: float = parameter(0.10, "Distance to the goal that counts as arrived", unit="m", low=0.01, high=5.0, live=True)
    stop_at_goal: bool = parameter(False, "A goal is reached at rest within goal_tolerance, instead of by passing", live=True)
    goal_timeout: float = parameter(120.0, "Time after which an accepted goal is aborted; 0 is never", unit="s", low=0.0, high=86400.0, live=True)
    longest_detour: float = parameter(20.0, "Way without coming nearer to the goal after which it is aborted, for strategies without memory of boundaries; 0 is never", unit="m", low=0.0, high=10000.0, live=True)
    recovery_tries: int = parameter(3, "How often a stuck robot backs out and tries again before the goal is aborted", low=0, high=100, live=True)
    frontier_spacing: float = parameter(0.08, "dl, spacing of candidate positions on a frontier", unit="m", low=0.01, high=0.5, live=True, of_radius=RADIUS)
    shortest_frontier: float = parameter(0.05, "Shorter frontiers are ignored if a longer one is seen", unit="m", low=0.0, high=0.5, live=True, of_radius=RADIUS)
    n_directions: int = parameter(8, "N_l, number of candidate velocity directions", low=4, high=64, live=True)
    n_speeds: int = parameter(4, "N_v, candidate speeds are 0 to v_max in so many steps", low=1, high=32, live=True)
    turn_penalty: float = parameter(5.0, "f_a, factor on J_pos where the turn reaches turn_threshold", low=1.0, high=1e3, live=True)
    turn_threshold: float = parameter(radians(70.0), "theta_thres, turn from which the penalty applies", unit="rad", low=0.0, high=pi, live=True)
    gap_weight: float = parameter(1.0, "f_theta, weight of the opening's width", unit="1/m", low=0.0, high=10.0, live=True)
    widest_gap: float = parameter(0.6, "Wider openings count as this wide, which is not narrow", unit="m", low=0.0, high=100.0, live=True, of_radius=RADIUS)
    speed_floor: float = parameter(0.05, "delta v, closing speed assumed for a candidate at rest", unit="m/s", low=0.001, high=1.0, live=True)
    time_floor: float = parameter(0.05, "Smallest time to collision; shorter ones count as this long", unit="s", low=1e-9, high=1.0, live=True)
    rebound_penalty: float = parameter(-1.0, "Reward of a rebound that ends in known free space", unit="m/s", low=-100.0, high=0.0, live=True)
    time_scale: float = parameter(1.3, "P_safe, factor on the time that the waypoints take at v_max", low=1.0, high=5.0, live=True)
    frontiers: str = parameter("all", "Shadow edges and visible runs of the map border, or shadow edges alone (obstacle-extending frontiers as printed)", choices=("all", "printed"), live=True)
    position_pruning: bool = parameter(True, "Drop frontiers represented by a nearby one that is closer to the goal", live=True)
    velocity_pruning: bool = parameter(True, "Drop velocity directions that lead back into known free space", live=True)
    position_cost: str = parameter("normalised_first", "J_pos: normalise then penalise, or as printed in Alg. 1", choices=("normalised_first", "printed"), live=True)
    turn_angle: str = parameter("turn", "Angle of Alg. 1: turn between successive aims, or the interior angle at p_cur as printed", choices=("turn", "printed"), live=True)
    gap_risk: str = parameter("opening_width", "J_risk,g: width of the opening at the candidate, or the bare angle as printed", choices=("opening_width", "printed"), live=True)
    approach_risk: str = parameter("crossing", "Adds 1 to J_risk where the approach crosses an observed boundary; printed adds nothing", choices=("crossing", "printed"), live=True)
    goal_vector: str = parameter("printed", "Goal vector of J_vel: p_goal - p_cur in metres as printed, or its unit vector", choices=("printed", "unit"), live=True)
    rebound_reward: bool = parameter(True, "R_ref in J_vel; false leaves it out (ablation)", live=True)
    collision_factor: bool = parameter(True, "Factor (1 - J_risk,h) in J_vel; false leaves it out (ablation)", live=True)
    speeds: str = parameter("fixed", "Speed set: n_speeds steps, or floor(frontier length / dl) steps as printed", choices=("fixed", "printed"), live=True)
    waypoints: str = parameter("clamped", "Inner waypoints: from the velocities at both ends, or evenly on the chord", choices=("clamped", "chord"), live=True)
    time_law: str = parameter("acceleration_limited", "T grows until the spline's peaks fit the motors, or as printed", choices=("acceleration_limited", "printed"), live=True)
    tie_rule: str = parameter("forward", "Equal costs when w_v = 0: prefer velocity along the approach, or the first candidate", choices=("forward", "first"), live=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if 0.0 < self.map_period < SHORTEST_MAP_PERIOD:
            raise ParameterError(f"planner.map_period: got {self.map_period}, expected at least {SHORTEST_MAP_PERIOD} s, or 0 for the strategy's own")


@dataclass(frozen=True)
class Remembered(Parameters):
    """Boundaries kept from earlier scans, and the solid assumed behind them. For the time-to-goal strategies."""

    group = "remembered"
    side: float = parameter(30.0, "Longest side of the space in which boundaries are kept; it begins as a square of 6 m and grows with the way", unit="m", low=1.0, high=30.0)
    spacing: float = parameter(0.02, "Spacing of the nodes at which the clearance is known, and length of a remembered piece", unit="m", low=0.005, high=0.1, of_radius=RADIUS)


@dataclass(frozen=True)
class TimeToGoal(Parameters):
    """Rollouts to the goal under the robot's own law, judged by the time they take. For the time-to-goal strategies."""

    group = "time_to_goal"
    half_side: float = parameter(1.2, "Half the side of the square around the robot within which scans are used", unit="m", low=0.2, high=5.0, of_radius=RADIUS)
    grid_spacing: float = parameter(0.03, "Spacing of the cells of the shortest paths", unit="m", low=0.01, high=0.2, of_radius=RADIUS)
    proposals: int = parameter(600, "Most changes tried on the best refined plan, and a third as many on a smooth one; fewer if they gain nothing more", low=0, high=100000)
    time_budget: float = parameter(0.0, "Time after the start of a cycle at which refinement ends with the best plan so far; 0 is never, so equal runs stay equal (planner_node: half of map_period)", unit="s", low=0.0, high=1.0)
    hit_cost: float = parameter(0.03, "bounce: cost of a contact by its speed into the boundary", unit="s per m/s", low=0.0, high=100.0)
    tolerant_distance: float = parameter(0.02, "bounce, tolerate: margin to boundaries that are not touched", unit="m", low=0.0, high=0.1, of_radius=RADIUS)
    averse_distance: float = parameter(0.03, "avoid, stop_guarantee: margin to boundaries", unit="m", low=0.0, high=0.1, of_radius=RADIUS)


@dataclass(frozen=True)
class Control(Parameters):
    """Tracking and maneuvers (paper, III-B)."""

    group = "controller"
    rate: float = parameter(20.0, "Rate of the velocity command", unit="Hz", low=1.0, high=200.0)
    stamped_cmd_vel: bool = parameter(False, "cmd_vel is a TwistStamped, for controller and robot alike, instead of a Twist")
    k_p: float = parameter(4.0, "Proportional gain on position", unit="1/s", low=0.0, high=50.0, live=True)
    turns_to_look: bool = parameter(False, "Turn a LIDAR that does not see all around to where the robot drives; false holds the first heading")
    boundary_projection: str = parameter("continuous", "q_bound continues along the tangent past the end of what was seen, at v_max at most, or jumps as printed", choices=("continuous", "printed"), live=True)
    maneuver_rule: str = parameter("incidence", "Alg. 3 by incidence at the contact, or left and right of the chord as printed", choices=("incidence", "printed"), live=True)


@dataclass(frozen=True)
class Cap(Parameters):
    """Hard limits that the robot itself enforces, whatever is commanded or set: in the driver and its firmware, and in the simulated robot."""

    group = "cap"
    speed: float = parameter(1.2, "Largest speed that the robot's end lets through, of the shape robot.velocity_shape; robot.max_speed must not exceed it", unit="m/s", low=0.05, high=5.0)
    acceleration: float = parameter(50.0, "Largest change of the commanded velocity let through, except a stop; a rebound requires 2 max_speed * controller.rate", unit="m/s^2", low=0.5, high=50.0)


@dataclass(frozen=True)
class Limits(Parameters):
    """Ages, by local receipt, beyond which an input counts as lost and the robot stops; and what else bounds it."""

    group = "limits"
    pose_age: float = parameter(0.15, "Largest age of a pose that is used", unit="s", low=0.02, high=0.5, live=True)
    scan_age: float = parameter(0.25, "Largest age of a scan that is used, since its receipt; one that comes later than this after its stamp is refused", unit="s", low=0.02, high=0.6, live=True)
    plan_age: float = parameter(0.6, "Oldest plan followed where no planner/trajectory gives its end of validity", unit="s", low=0.05, high=2.0, live=True)
    command_age: float = parameter(0.2, "Age of the last command after which the robot applies zero", unit="s", low=0.02, high=0.5)
    motion_delay: float = parameter(0.1, "Longest delay from a command to the motion measured, beyond which the robot stops", unit="s", low=0.05, high=0.4)
    missing_beams: float = parameter(0.15, "Largest share of beams in which a scan may lack walls that earlier scans showed", low=0.05, high=0.45)
    lost_beams: float = parameter(0.5, "Largest share of the unmasked beams that may have measured nothing (NaN)", low=0.0, high=0.9)
    pose_history: float = parameter(0.5, "Time for which poses are kept, to find the one at a scan's stamp", unit="s", low=0.1, high=10.0)
    excess_speed: float = parameter(1.5, "Commands up to this multiple of max_speed are clipped, faster ones refused", low=1.0, high=3.0)
    hand_age: float = parameter(0.2, "Age of the last command on hand/cmd_vel after which the hand has let go", unit="s", low=0.05, high=0.5)
    blind_speed: float = parameter(0.3, "Largest speed by hand if poses are lost or the motion does not fit the commands", unit="m/s", low=0.0, high=1.0)
    unvouched_speed: float = parameter(0.5, "Largest speed to a goal while no wall of 0.5 m is within 3 m: nothing vouches for the scans there", unit="m/s", low=0.05, high=5.0)
    heartbeat_age: float = parameter(0.2, "Silence of planner/heartbeat after which the robot stops, once one was received", unit="s", low=0.1, high=0.5)
    goal_distance: float = parameter(100.0, "A goal farther from the robot is refused", unit="m", low=1.0, high=1000.0)
    fence: tuple[float, ...] = parameter((), "Corners x, y, x, y, ... in frames.map of a polygon that goals and the robot's centre must be in; empty for none", unit="m", low=-1e6, high=1e6)
    impact_speed: float = parameter(1.2, "Contacts faster than this into an obstacle are not planned by the time-to-goal strategies, and counted with the paper's; v_max excludes none (assumed)", unit="m/s", low=0.0, high=10.0)
    mover_speed: float = parameter(0.0, "The controller sends no command after which the robot could touch what moves at more than this speed of its own", unit="m/s", low=0.0, high=5.0, live=True)
    emerging_speed: float = parameter(0.0, "Speed of what may come out of places that the robot does not see; the robot drives only as fast as it can stop before it. 0 expects nothing", unit="m/s", low=0.0, high=5.0, live=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        reason = why_no_polygon(self.fence)
        if reason:
            raise ParameterError(f"limits.fence: got {list(self.fence)}, {reason}")


@dataclass(frozen=True)
class Mocap(Parameters):
    """Pose ingestion: the velocity filter, impacts, and what is refused."""

    group = "mocap"
    velocity_window: float = parameter(0.06, "Poses of this span are fitted for the velocity; the delay is half of it", unit="s", low=0.01, high=0.5, live=True)
    detect_impacts: bool = parameter(True, "Detect impacts in the poses; false if the ring itself senses them", live=True)
    position_noise: float = parameter(0.002, "Noise of a measured position, standard deviation by axis (assumed)", unit="m", low=1e-5, high=0.1, live=True)
    yaw_noise: float = parameter(0.005, "Noise of a measured yaw, standard deviation, published as covariance on mocap/odom (assumed)", unit="rad", low=1e-6, high=0.5, live=True)
    impact_window: float = parameter(0.05, "A change of velocity within this time that max_acceleration cannot make is an impact", unit="s", low=0.02, high=0.2, live=True)
    impact_speed: float = parameter(0.15, "Smallest change of velocity reported as an impact", unit="m/s", low=0.01, high=5.0, live=True)
    leap_margin: float = parameter(0.05, "Distance beyond max_speed times the silence that still counts as motion", unit="m", low=0.0, high=1.0, live=True)
    relocation_time: float = parameter(0.5, "Poses that agree for so long after a leap are accepted as a relocation", unit="s", low=0.1, high=10.0, live=True)
    quaternion_tolerance: float = parameter(0.01, "Largest deviation of a quaternion's norm from 1", low=1e-6, high=0.5, live=True)
    max_spin: float = parameter(9.0, "Fastest turn that still counts as motion, as after an oblique hit", unit="rad/s", low=1.0, high=30.0)
    yaw_margin: float = parameter(0.2, "Turn beyond max_spin times the silence that still counts as motion", unit="rad", low=0.02, high=0.5)
    max_tilt: float = parameter(radians(15.0), "Largest angle between the body's z axis and the vertical; pi is any", unit="rad", low=0.02, high=pi)
    max_lift: float = parameter(0.05, "Largest height off the plane through the poses so far, which may be tilted by 5 degrees; 100 is any", unit="m", low=0.005, high=100.0)
    publish_tf: bool = parameter(False, "Broadcast the transform from map to base_link; requires tf2_msgs")
    format: str = parameter("pose", "Messages of the motion capture's receiver", choices=("pose", "pose_with_covariance", "odometry", "transform", "tf", "named_poses", "rigid_bodies", "vicon"))
    topic: str = parameter("mocap/pose", "Topic of the motion capture's messages")
    reliability: str = parameter("best_effort", "Reliability of the subscription to the motion capture; best_effort receives reliable messages too", choices=("best_effort", "reliable"))
    rate: float = parameter(0.0, "Poses per second, for a receiver that stamps at receipt and delivers in bursts: poses get even stamps in their order of arrival. 0 believes header.stamp", unit="Hz", low=0.0, high=1000.0)
    subject: str = parameter("", "Name of the robot's body in messages with several; empty accepts any in messages with one")
    frame: str = parameter("", "header.frame_id of the messages; empty for frames.map. Its axes become those of frames.map")
    units: str = parameter("m", "Unit of measured positions", choices=("m", "mm"))
    axes: str = parameter("z_up", "Which axis points up; y-up coordinates x, y, z become x, -z, y", choices=("z_up", "y_up"))
    floor_tilt: tuple[float, ...] = parameter((0.0, 0.0), "Slopes of the floor in these axes, z up: rise along x, and along y. Small ones are also found while driving", unit="rad", low=-0.2, high=0.2)
    body_offset_x: float = parameter(0.0, "The measured body's origin seen from the robot's centre: forward", unit="m", low=-1.0, high=1.0)
    body_offset_y: float = parameter(0.0, "The measured body's origin seen from the robot's centre: to the left", unit="m", low=-1.0, high=1.0)
    body_offset_yaw: float = parameter(0.0, "Heading of the measured body seen from the robot", unit="rad", low=-pi, high=pi)
    accept_frozen: bool = parameter(False, "Accept a pose that equals the last one to the last bit; true for a simulation without noise. Format odometry always does", live=True)
    localised: bool = parameter(False, "A localisation ties mocap.frame, as odom, to frames.map on /tf: poses are moved by the newest transform between them; requires tf2_msgs")
    largest_correction: float = parameter(0.3, "Largest change of the robot's place by one correction of the localisation; beyond it the robot counts as carried", unit="m", low=0.01, high=10.0)
    slip_time: float = parameter(0.0, "Time after an impact for which odometry is not believed, as wheels slip then; 0 for a motion capture", unit="s", low=0.0, high=0.5)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_topic("mocap.topic", self.topic)
        if len(self.floor_tilt) != 2:
            raise ParameterError(f"mocap.floor_tilt: got {len(self.floor_tilt)} numbers, expected two slopes")


@dataclass(frozen=True)
class ScanInput(Parameters):
    """Scan ingestion: where the LIDAR is on the robot, and what of its scans is used."""

    group = "scan"
    frame: str = parameter("", "header.frame_id of the scans; empty for frames.base")
    offset_x: float = parameter(0.0, "The LIDAR seen from the robot's centre: forward", unit="m", low=-1.0, high=1.0)
    offset_y: float = parameter(0.0, "The LIDAR seen from the robot's centre: to the left", unit="m", low=-1.0, high=1.0)
    offset_yaw: float = parameter(0.0, "Heading of the LIDAR seen from the robot", unit="rad", low=-pi, high=pi)
    mirrored: bool = parameter(False, "Its angles count clockwise seen from above, as when mounted upside down")
    stamp_offset: float = parameter(0.0, "Start of the sweep after header.stamp; negative if the driver stamps later", unit="s", low=-0.5, high=0.5)
    instant: bool = parameter(False, "All beams are of one moment, as those made of a point cloud: time_increment and scan_time are not read")
    backwards: bool = parameter(False, "The first beam of a message was measured last, as when a driver reverses the order of a LIDAR that turns clockwise")
    zero: str = parameter("near", "Meaning of a range of 0: nearer than range_min (REP-117), lost, or nothing within range_max", choices=("near", "lost", "free"))
    codes_below: float = parameter(0.0, "Ranges up to this are codes of the device and mean what a range of 0 does", unit="m", low=0.0, high=0.1)
    infinite: str = parameter("free", "Meaning of a range of +Inf: nothing within range_max (REP-117), or lost, for devices that give it for everything not measured", choices=("free", "lost"))
    min_intensity: float = parameter(0.0, "Ranges with less intensity count as lost, in messages with intensities", low=0.0, high=1e6)
    masked_angles: tuple[float, ...] = parameter((), "From, to, from, to, ... in the messages' angles, counter-clockwise: beams between are not used, such as those that see the robot itself", unit="rad", low=-2 * pi, high=2 * pi)
    median: int = parameter(1, "Each range becomes the median of this many beams around it, to remove speckles; odd, 1 is none", low=1, high=9)

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.masked_angles) % 2:
            raise ParameterError(f"scan.masked_angles: got {len(self.masked_angles)} numbers, expected pairs: from, to, from, to, ...")
        if self.median % 2 == 0:
            raise ParameterError(f"scan.median: got {self.median}, expected an odd number of beams")

    @property
    def offset(self) -> tuple[float, float, float]:
        """Mounting pose of the LIDAR on the robot: x, y [m] and heading [rad]."""
        return self.offset_x, self.offset_y, self.offset_yaw


@dataclass(frozen=True)
class MoverFinding(Parameters):
    """Detection of movers, and the space that one is given."""

    group = "movers"
    margin: float = parameter(0.03, "A return so deep in space that was seen to be free has come there by moving; noise of ranges and the spacing of beams are added", unit="m", low=0.01, high=0.3)
    standing_time: float = parameter(0.25, "A surface that stayed in place for so long stands; bounce and tolerate choose no other for a contact within that time and 0.35 s. 0 takes any", unit="s", low=0.0, high=3.0)
    kept: float = parameter(0.6, "Time for which a mover that is out of sight is still expected", unit="s", low=0.05, high=5.0)
    memory: float = parameter(60.0, "Time for which a mover that stopped and is hidden is remembered as one, and no wall to hit, unless a scan shows its place free before. 0 is no limit", unit="s", low=0.0, high=3600.0)
    growth: float = parameter(0.25, "How fast a mover may leave its predicted way, K of S = K T + C", unit="m/s", low=0.0, high=5.0)
    clearance: float = parameter(0.05, "Distance kept from a mover, C of S = K T + C", unit="m", low=0.0, high=1.0)


@dataclass(frozen=True)
class Lidar(Parameters):
    """Simulated LIDAR: ray casting against a world. Sensor low_cost has rate, beams, span and limits of its own."""

    group = "lidar"
    world: str = parameter("corridor", "World scanned: NAME, FILE or FAMILY:SEED")
    rate: float = parameter(20.0, "Scans per second", unit="Hz", low=1.0, high=100.0)
    n_beams: int = parameter(360, "Beams of a scan", low=30, high=2000)
    angle_min: float = parameter(-pi, "Direction of the first beam", unit="rad", low=-2 * pi, high=2 * pi)
    angle_span: float = parameter(2 * pi, "Angle covered; a full turn does not repeat its first beam", unit="rad", low=0.1, high=2 * pi)
    range_min: float = parameter(0.02, "Nearest range; nearer is -Inf", unit="m", low=0.0, high=1.0)
    range_max: float = parameter(5.0, "Farthest range; farther is +Inf", unit="m", low=0.1, high=100.0)
    sensor: str = parameter("ideal", "Kind of sensor: ideal casts rays as in the paper; low_cost is a spinning sensor with noise, lost and mixed returns, latency and sweep", choices=("ideal", "low_cost"))
    range_noise: float = parameter(0.0, "Noise of a range of sensor ideal, standard deviation; low_cost has its own", unit="m", low=0.0, high=0.2)
    seed: int = parameter(0, "Seed of the noise of ranges; a trial uses its own seed instead", low=0, high=2**31 - 1)
    frame: str = parameter("", "header.frame_id of the scans; empty for frames.base. Planner and controller expect scan.frame")
    offset_x: float = parameter(0.0, "True place of the sensor on the robot: forward. Planner and controller use scan.offset_x", unit="m", low=-1.0, high=1.0)
    offset_y: float = parameter(0.0, "True place of the sensor on the robot: to the left. Planner and controller use scan.offset_y", unit="m", low=-1.0, high=1.0)
    offset_yaw: float = parameter(0.0, "True heading of the sensor on the robot. Planner and controller use scan.offset_yaw", unit="rad", low=-pi, high=pi)
    mirrored: bool = parameter(False, "Its angles truly count clockwise, as of one mounted upside down. Planner and controller use scan.mirrored")
    stamp_offset: float = parameter(0.0, "True start of the sweep after header.stamp. A message comes no sooner than its stamp; planner and controller use scan.stamp_offset", unit="s", low=-0.5, high=0.5)
    sweep: str = parameter("forwards", "Order in which low_cost measures its beams: as in the message, the last one first, or all at the sweep's start, while the message says that it takes a turn. Planner and controller use scan.backwards and scan.instant", choices=("forwards", "backwards", "instant"))
    fault: str = parameter("none", "Error of the ranges: flat gives +Inf where a wall is met within 10 degrees of its own direction, zeros 0 for what was not measured, and repeats, of a driver that polls, the last ranges again until 0.15 s are over", choices=("none", "flat", "zeros", "repeats"))

    @property
    def offset(self) -> tuple[float, float, float]:
        """True mounting pose of the sensor on the robot: x, y [m] and heading [rad]."""
        return self.offset_x, self.offset_y, self.offset_yaw


@dataclass(frozen=True)
class Simulation(Parameters):
    """The simulated Omnipuck: the truth, which the planner is not given. Restitution, friction, noise are assumed."""

    group = "simulator"
    engine: str = parameter("pymunk", "Engine for contacts: pymunk (rigid), or mujoco (compliant ring), which must be installed separately", choices=("pymunk", "mujoco"))
    world: str = parameter("corridor", "World simulated: NAME, FILE or FAMILY:SEED")
    seed: int = parameter(0, "Seed of every random number", low=0, high=2**31 - 1)
    physics_rate: float = parameter(800.0, "Physics steps per second", unit="Hz", low=400.0, high=10000.0)
    speed_factor: float = parameter(1.0, "Simulated seconds per second; 0 where bringup runs all nodes in one process and time waits for them; other values than 1 require use_sim_time in all nodes", low=0.0, high=50.0)
    restitution: float = parameter(0.7, "True restitution of the ring (assumed)", low=0.0, high=1.0)
    restitution_spread: float = parameter(0.0, "Half width of the uniform spread of the restitution from hit to hit", low=0.0, high=0.5)
    wall_spread: float = parameter(0.0, "Half width of the uniform spread of the restitution's factor from wall to wall", low=0.0, high=0.9)
    friction: float = parameter(0.12, "True Coulomb friction of ring and wall (assumed)", low=0.0, high=5.0)
    friction_spread: float = parameter(0.0, "Half width of the uniform spread of the friction from hit to hit", low=0.0, high=5.0)
    contact_time: float = parameter(0.015, "How long a compliant ring touches in a hit, mujoco only (assumed)", unit="s", low=0.005, high=0.1)
    mass_ratio: float = parameter(1.0, "True mass over robot.mass, with the same motors: acceleration and lag follow", low=0.2, high=5.0)
    acceleration_ratio: float = parameter(1.0, "True acceleration of the motors over robot.max_acceleration", low=0.2, high=5.0)
    wheel_mass: float = parameter(0.0, "True reflected mass of wheels and motors (assumed)", unit="kg", low=0.0, high=10.0)
    noise: float = parameter(1.0, "Level of all noise; 0 is none", low=0.0, high=10.0)
    mocap_noise: float = parameter(0.002, "Position noise of a mocap pose, standard deviation by axis, at level 1", unit="m", low=0.0, high=0.1)
    mocap_yaw_noise: float = parameter(0.0, "Yaw noise of a mocap pose, standard deviation, at level 1", unit="rad", low=0.0, high=0.2)
    mocap_latency: float = parameter(0.0, "Time from a pose's stamp until the motion capture sends it", unit="s", low=0.0, high=0.5)
    mocap_rate: float = parameter(100.0, "Mocap poses per second", unit="Hz", low=10.0, high=400.0)
    mocap_fault: str = parameter("none", "Error of the motion capture: yaw off by 90 or 180 degrees, tipped by 30 degrees, lifted by 0.2 m, poses 0.2 s late, stamps off by an hour, bursts each 50 ms that are stamped at receipt, or each value repeated until 0.1 s are over", choices=("none", "yaw_90", "yaw_180", "tilt", "lift", "late", "hour_ahead", "hour_back", "bursts", "repeats"), live=True)
    floor_tilt: tuple[float, ...] = parameter((0.0, 0.0), "Slopes of the floor in the motion capture's axes, which are tilted: rise along x, and along y", unit="rad", low=-0.2, high=0.2)
    marker_offset_x: float = parameter(0.0, "True place of the measured body's origin on the robot: forward", unit="m", low=-1.0, high=1.0)
    marker_offset_y: float = parameter(0.0, "True place of the measured body's origin on the robot: to the left", unit="m", low=-1.0, high=1.0)
    marker_offset_yaw: float = parameter(0.0, "True heading of the measured body on the robot", unit="rad", low=-pi, high=pi)

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.floor_tilt) != 2:
            raise ParameterError(f"simulator.floor_tilt: got {len(self.floor_tilt)} numbers, expected two slopes")

    @property
    def publishes_clock(self) -> bool:
        """True where the simulator publishes /clock, which all nodes then follow."""
        return self.speed_factor != 1.0


@dataclass(frozen=True)
class Kinematics(Parameters):
    """The omni wheels, seen from above. All assumed."""

    group = "kinematics"
    wheel_angles: tuple[float, ...] = parameter((pi / 3, pi, 5 * pi / 3), "Angle at which each wheel is mounted, from x forward, counter-clockwise; it drives along its tangent in that sense (assumed)", unit="rad", low=-2 * pi, high=2 * pi)
    mount_radius: float = parameter(0.07, "Distance of the wheels from the centre (assumed)", unit="m", low=0.005, high=1.0)
    wheel_radius: float = parameter(0.02, "Radius of a wheel (assumed)", unit="m", low=0.002, high=0.5)
    max_wheel_speed: float = parameter(80.0, "Largest commanded speed of a wheel; all wheels are slowed in proportion (assumed)", unit="rad/s", low=0.1, high=1000.0)


@dataclass(frozen=True)
class Driver(Parameters):
    """The serial link to the firmware."""

    group = "driver"
    port: str = parameter("/dev/ttyUSB0", "Serial device")
    baud: int = parameter(115200, "Baud rate of the serial device, equal to the firmware's", unit="bit/s", low=9600, high=4000000)
    rate: float = parameter(50.0, "Commands sent per second: at least two in limits.command_age, no more than driver.baud carries", unit="Hz", low=5.0, high=200.0)


@dataclass(frozen=True)
class Base(Parameters):
    """A robot of any make that takes velocities in its body frame; for base_node."""

    group = "base"
    topic: str = parameter("/cmd_vel", "Topic on which the base takes velocities")
    stamped: bool = parameter(False, "The base takes TwistStamped instead of Twist")
    rate: float = parameter(20.0, "Velocities sent per second, also while they are zero", unit="Hz", low=1.0, high=200.0)
    watchdog: float = parameter(0.5, "Silence after which the base stops by itself: base.rate sends at least twice in it. 0 where it has no watchdog", unit="s", low=0.0, high=10.0)
    touch: str = parameter("none", "What the base tells of a touch: bool is a contact, hit a robomaster_msgs/ArmorHit, imu accelerations in which a hit is a spike. One that gives the change of velocity publishes it on impact itself", choices=("none", "bool", "hit", "imu"))
    touch_topic: str = parameter("/touch", "Topic of these messages")
    touch_acceleration: float = parameter(15.0, "Horizontal acceleration from which on an imu shows a hit", unit="m/s^2", low=1.0, high=1000.0)
    runaway_time: float = parameter(0.5, "Time beyond the way to brake after which a base that was told to stand and moves is held as one that does not obey", unit="s", low=0.1, high=5.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_topic("base.topic", self.topic)
        check_topic("base.touch_topic", self.touch_topic)


@dataclass(frozen=True)
class EmulatorFaults(Parameters):
    """Faults that the emulated firmware is asked for: the text of emulator.faults. Shares hold in both directions."""

    group = "emulator.faults"
    baud: int = parameter(115200, "Baud rate of the firmware; at another one both ends read garbage", unit="bit/s", low=9600, high=4000000)
    protocol_version: int = parameter(2, "Version of the protocol that the firmware speaks", low=0, high=255)
    n_wheels: int = parameter(0, "Wheels that the firmware announces; 0 for as many as kinematics.wheel_angles has", low=0, high=8)
    flipped: float = parameter(0.0, "Share of bytes with one bit flipped", low=0.0, high=1.0)
    lost: float = parameter(0.0, "Share of frames that vanish", low=0.0, high=1.0)
    doubled: float = parameter(0.0, "Share of frames that come twice", low=0.0, high=1.0)
    cut: float = parameter(0.0, "Share of frames that end too early", low=0.0, high=1.0)
    split: float = parameter(0.0, "Share of frames whose second part comes later", low=0.0, high=1.0)
    noise: float = parameter(0.0, "Share of frames with noise before them", low=0.0, high=1.0)
    stall: float = parameter(0.0, "Time for which the firmware hangs when this is set", unit="s", low=0.0, high=10.0)
    restarts: int = parameter(0, "The firmware restarts whenever this becomes another number than 0", low=0, high=2**31 - 1)
    unplugged: bool = parameter(False, "The cable is pulled")
    estop_pressed: bool = parameter(False, "The button on the robot is pressed")
    battery: float = parameter(7.6, "Voltage of the battery; low below 6.6 V", unit="V", low=0.0, high=60.0)
    motor_fault: bool = parameter(False, "A motor has failed")
    too_hot: bool = parameter(False, "The motors are too hot")

    @classmethod
    def read(cls, text: str) -> "EmulatorFaults":
        """Reads a text such as "lost=0.1, unplugged"; raises ParameterError for an unknown fault or a wrong value."""
        faults = {spec.key.rpartition(".")[2]: spec.default for spec in specs(cls)}
        asked = {}
        for part in filter(None, (each.strip() for each in text.split(","))):
            name, value = (each.strip() for each in f"{part}=true".split("=")[:2])
            if name not in faults:
                raise ParameterError(f"emulator.faults: got {part!r}, expected some of {', '.join(faults)}, as lost=0.1, unplugged")
            try:
                asked[name] = parse_yaml(value)
            except YamlError as error:
                raise ParameterError(f"emulator.faults: got {part!r}: {error}") from None
        return cls(**asked)


@dataclass(frozen=True)
class Emulator(Parameters):
    """The emulated firmware around the simulated robot."""

    group = "emulator"
    firmware: str = parameter("python", "Firmware: the emulated one, or the reference in C, compiled by cc", choices=("python", "c"))
    link: str = parameter("/tmp/omnipuck", "Path of the link to the pseudo-terminal, for driver.port")
    senses_impacts: bool = parameter(False, "The ring senses impacts and the firmware reports them")
    faults: str = parameter("", f"Faults, as lost=0.1, unplugged: {', '.join(spec.key.rpartition('.')[2] for spec in specs(EmulatorFaults))}", live=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self.asked  # noqa: B018 (a wrong text is refused here)

    @cached_property
    def asked(self) -> EmulatorFaults:
        """The faults of the text."""
        return EmulatorFaults.read(self.faults)


@dataclass(frozen=True)
class Frames(Parameters):
    """Names of the coordinate frames (REP-105)."""

    group = "frames"
    map: str = parameter("map", "World frame, defined by the motion capture")
    base: str = parameter("base_link", "Robot frame: x forward, y left, z up")


@dataclass(frozen=True)
class View(Parameters):
    """The live page of view_node, on 127.0.0.1 alone."""

    group = "view"
    port: int = parameter(8090, "Port of the page, on this machine alone; 0 is any free one", low=0, high=65535)


@dataclass(frozen=True)
class Trial(Parameters):
    """Conditions that end a run."""

    group = "trial"
    timeout: float = parameter(30.0, "Longest duration of a run", unit="s", low=1.0, high=3600.0)
    stuck_time: float = parameter(5.0, "Time within which progress is required", unit="s", low=0.5, high=600.0)
    stuck_distance: float = parameter(0.05, "Progress required in stuck_time", unit="m", low=0.0, high=10.0)
    known_map: bool = parameter(False, "Give the planner the whole map, to measure the cost of not knowing it; time-to-goal strategies, in trials and studies only")


GROUPS: tuple[type[Parameters], ...] = (
    Robot, Rebound, LocalMapping, Weights, Planning, Remembered, TimeToGoal, Control, Cap, Limits, Mocap, ScanInput, MoverFinding, Lidar, Simulation, Kinematics,
    Driver, Base, Emulator, Frames, View, Trial,
)


@dataclass(frozen=True)
class Settings:
    """One of each group: everything a closed loop needs."""

    robot: Robot = Robot()
    rebound: Rebound = Rebound()
    local_map: LocalMapping = LocalMapping()
    weights: Weights = Weights()
    planner: Planning = Planning()
    remembered: Remembered = Remembered()
    time_to_goal: TimeToGoal = TimeToGoal()
    controller: Control = Control()
    cap: Cap = Cap()
    limits: Limits = Limits()
    mocap: Mocap = Mocap()
    scan: ScanInput = ScanInput()
    movers: MoverFinding = MoverFinding()
    lidar: Lidar = Lidar()
    simulator: Simulation = Simulation()
    kinematics: Kinematics = Kinematics()
    driver: Driver = Driver()
    base: Base = Base()
    emulator: Emulator = Emulator()
    frames: Frames = Frames()
    view: View = View()
    trial: Trial = Trial()

    def with_values(self, values: dict[str, Any]) -> "Settings":
        """Settings in which some `group.field` keys have other values.

        Raises:
            ParameterError: a key that does not exist, or a value that does not fit it.
        """
        known = all_specs()
        by_group: dict[str, dict[str, Any]] = {}
        for key, value in {**values, **self._scaled(values, known)}.items():
            if key not in known:
                raise unknown_key(key)
            group, name = key.split(".")
            by_group.setdefault(group, {})[name] = value
        return replace(self, **{g: replace(getattr(self, g), **v) for g, v in by_group.items()})

    def _scaled(self, values: dict[str, Any], known: dict[str, Spec]) -> dict[str, Any]:
        """The lengths that are at their defaults, for the radius among the values."""
        before, now = self.robot.radius, known["robot.radius"].checked(values.get("robot.radius", self.robot.radius))
        if before == now == RADIUS:
            return {}
        present = self.values()
        return {
            key: spec.default_at(now)
            for key, spec in known.items()
            if spec.of_radius
            and values.get(key, spec.default) == spec.default
            and (key in values or present[key] == spec.default_at(before))
        }

    def values(self) -> dict[str, Any]:
        """Every `group.field` key and its value."""
        return {f"{g.name}.{f.name}": getattr(getattr(self, g.name), f.name) for g in fields(self) for f in fields(getattr(self, g.name))}


GONE = {
    "time_to_goal.speed_limit": "limits.impact_speed takes its place",
    "time_to_goal.clearance_cost": "a constant cost of places within the margin takes its place",
    "time_to_goal.limit_cost": "contacts faster than limits.impact_speed have no price, they are not planned",
}
"""Removed parameters, and their replacements."""
LOCKSTEP = "simulator.lockstep"
WITHOUT_EFFECT = (
    *("simulator.controller_lateness", "simulator.planner_lateness", "simulator.sensor_lateness", "simulator.patience"),
    "robot.motion_delay_estimated",
    "teleop.",
    *(f"local_map.{name}" for name in ("clearance", "surface_tolerance", "grazing_angle", "sight_share")),
    *(f"planner.{name}" for name in ("rebound_horizon", "prune_distance", "acceleration_factor", "n_samples")),
    *(f"remembered.{name}" for name in ("max_pieces", "inferred_depth", "inferred_inset", "contradiction")),
    *(f"time_to_goal.{name}" for name in ("horizon", "n_starts", "start_proposals", "arrival_share", "graze_cost", "longest_plan", "averse_cost", "averse_speed_cost", "inferred_cost", "margin_cost")),
    *(f"controller.{name}" for name in ("k_i", "k_d", "integral_limit", "k_yaw", "max_yaw_rate", "incidence_threshold", "switch_distance", "full_acceleration_lead")),
    *(f"simulator.{name}" for name in ("restitution_slope", "floor_friction", "max_yaw_acceleration", "actuation_noise", "actuation_bias", "start_noise")),
    *(f"driver.{name}" for name in ("link_timeout", "longest_wait")),
    *(f"view.{name}" for name in ("rate", "clients")),
    *(f"emulator.{name}" for name in ("telemetry_rate", *(spec.key.rpartition(".")[2] for spec in specs(EmulatorFaults)))),
)
"""Beginnings of the keys of removed parameters that are ignored. Files of earlier versions hold them, and LOCKSTEP for a speed_factor of 0."""


def all_specs() -> dict[str, Spec]:
    """Every parameter of the project by key."""
    return {spec.key: spec for group in GROUPS for spec in specs(group)}


def is_without_effect(key: str) -> bool:
    """Whether a key is of a removed parameter that is ignored."""
    return key.startswith(WITHOUT_EFFECT)


def without_effect(keys: Iterable[str]) -> str:
    """A sentence on those of the keys that are of removed parameters; "" where there are none."""
    gone = [key for key in keys if is_without_effect(key)]
    more = f" and {len(gone) - 1} more" if len(gone) > 1 else ""
    return f"{gone[0]}{more}: no longer a parameter, has no effect" if gone else ""


def unknown_key(key: str) -> ParameterError:
    """The error for a key that no group declares, with what has taken its place or the nearest known ones."""
    from difflib import get_close_matches

    if key in GONE:
        return ParameterError(f"{key}: no longer a parameter, {GONE[key]}")
    if key.startswith("qos_overrides."):
        return ParameterError(f"{key}: has no effect, expected no such key: the quality of service of topics is fixed")
    known = all_specs()
    field = key.rpartition(".")[2]
    near = [each for each in known if each.endswith(f".{field}")] or get_close_matches(key, known, n=3, cutoff=0.7)
    return ParameterError(f"{key}: unknown parameter" + (f", did you mean {' or '.join(near)}?" if near else ""))
