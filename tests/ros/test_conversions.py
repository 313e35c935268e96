"""Records to messages and back; what a message may not hold."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Twist, TwistStamped
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import LaserScan

from collplan_core.command import Command
from collplan_core.impact import SOURCES, Impact
from collplan_core.local_map import build_local_map
from collplan_core.parameters import ScanInput, Settings
from collplan_core.parameters.file import read_parameters
from collplan_core.poses.pose_filter import Deviations
from collplan_core.scan import Scan, ScanError
from collplan_core.state import State
from collplan_ros.messages import conversions as c
from collplan_ros.messages import reading as r
from collplan_ros.messages.cloud_reading import impact_from_cloud
from collplan_ros.messages.conversions import command_to_message, command_type
from collplan_ros.messages.planner_clouds import impact_to_cloud
from collplan_ros.messages.raw_reading import state_from_bytes
from collplan_ros.messages.reading import scan_from_message, suspiciously_near, twist_of

CONFIG = Path(__file__).parents[2] / "src/collplan_ros/collplan_ros/config"
FEW = settings(derandomize=True, deadline=None, max_examples=30)
numbers = st.floats(-1e3, 1e3)
points = st.tuples(numbers, numbers).map(np.array)
yaws = st.floats(-math.pi + 1e-6, math.pi)
stamps = st.integers(0, 2 * 10**18).map(lambda nanoseconds: nanoseconds / 1e9)


def sent(message):
    return deserialize_message(serialize_message(message), type(message))


# ---- stamps and angles


@given(st.floats(-1e3, 2.1e9), st.integers(0, 10**6), st.integers(0, 10**9 - 1))
@FEW
def test_seconds_survive_stamps(seconds, sec, nanosec):
    once = r.seconds_from_stamp(c.stamp_from_seconds(seconds))
    assert once == pytest.approx(seconds, abs=5.1e-10)
    assert r.seconds_from_stamp(c.stamp_from_seconds(once)) == once
    stamp = c.stamp_from_seconds(r.seconds_from_stamp(Time(sec=sec, nanosec=nanosec)))
    assert (stamp.sec, stamp.nanosec) == (sec, nanosec)


@given(yaws)
@FEW
def test_yaw_survives_a_quaternion(yaw):
    turned = sent(c.quaternion_from_yaw(yaw))
    assert r.yaw_of(turned.x, turned.y, turned.z, turned.w) == pytest.approx(yaw, abs=1e-12)


# ---- poses


def test_odometry_says_how_far_off_it_may_be():
    state = State(0.0, np.zeros(2), np.array([0.0, 0.7]), math.pi / 2)
    deviations = Deviations(0.1, 0.2, 0.3, 0.4)
    message = sent(c.state_to_odometry(state, "map", "base_link", -1.5, deviations))
    assert message.twist.twist.angular.z == -1.5
    assert (message.header.frame_id, message.child_frame_id) == ("map", "base_link")
    # along y of the map with the nose along y: straight ahead
    assert (message.twist.twist.linear.x, message.twist.twist.linear.y) == pytest.approx((0.7, 0.0), abs=1e-12)
    for held, along, about in ((message.pose, 0.01, 0.04), (message.twist, 0.09, 0.16)):
        covariance = held.covariance.reshape(6, 6)
        np.testing.assert_allclose(np.diag(covariance), [along, along, 1e6, 1e6, 1e6, about])
        assert np.count_nonzero(covariance) == 6


BAD_ODOMETRY = (
    (lambda m: setattr(m.header, "frame_id", "odom"), "header.frame_id"),
    (lambda m: setattr(m.pose.pose.position, "y", math.nan), "pose.position"),
    (lambda m: setattr(m.pose.pose.orientation, "w", 1.1), "orientation"),
)


def test_odometry_that_is_refused():
    for change, words in BAD_ODOMETRY:
        message = c.state_to_odometry(State(0.0, np.zeros(2), np.zeros(2), 0.0), "map", "base_link")
        change(message)
        with pytest.raises(r.MessageError, match=words):
            state_from_bytes(serialize_message(message), "map", "base_link")


@given(stamps, points)
@FEW
def test_goal_and_impact(stamp, point):
    goal = sent(c.goal_to_message(point, "map"))
    goal.pose.orientation.w = 0.0  # it needs none
    np.testing.assert_array_equal(r.goal_from_message(goal, "map"), point)
    at, value = r.impact_from_message(sent(c.impact_to_message(stamp, point, "map")), "map")
    assert at == stamp
    np.testing.assert_array_equal(value, point)


@given(stamps, points, points, points, yaws, st.sampled_from(SOURCES), st.booleans())
@FEW
def test_impact(stamp, point, before, after, angle, source, moves):
    normal = np.array([math.cos(angle), math.sin(angle)])
    given_impact = Impact(stamp, point, normal, before, after, source, moves)
    impact = impact_from_cloud(sent(impact_to_cloud(given_impact, "map")), "map")
    assert (impact.time, impact.source, impact.with_mover) == (stamp, source, moves)
    for name, value in {"point": point, "normal": normal, "velocity_before": before, "velocity_after": after}.items():
        np.testing.assert_array_equal(getattr(impact, name), value)


# ---- scans

ranges = st.one_of(st.floats(0.02, 5.0), st.sampled_from([math.inf, -math.inf, math.nan]))


@given(
    stamps,
    st.lists(ranges, min_size=2, max_size=50).filter(lambda r: not np.isnan(r).all()),
    st.floats(-math.pi, math.pi),
    st.floats(0.01, 0.12),
)
@FEW
def test_scan(stamp, values, first, step):
    scan = Scan(stamp, first, step, 0.02, 5.0, np.array(values))
    back = scan_from_message(sent(c.scan_to_message(scan, "base_link")), "base_link")
    assert back.stamp == stamp
    np.testing.assert_array_equal(back.ranges, scan.ranges.astype(np.float32))
    np.testing.assert_allclose(back.angles, scan.angles, atol=1e-5)


def turn_of(n_beams, step, last):
    message = LaserScan(angle_min=-math.pi, angle_max=last, angle_increment=step, range_max=10.0)
    message.header.frame_id, message.ranges = "base_link", [1.0] * n_beams
    return message


@pytest.mark.parametrize("step", [0.004, 0.005, 0.0064, 0.007, 0.0075, 0.0174533, 0.0031, 0.00613, 0.0123, 0.0211])
def test_drivers_that_round_the_number_of_beams_or_end_one_step_further(step):
    whole = math.tau / step
    for n_beams in {math.floor(whole), math.ceil(whole), round(whole)} - {math.ceil(whole) + 1}:
        for last in (math.pi, math.pi - step, -math.pi + (n_beams - 1) * step):
            if (n_beams - 1) * step <= math.tau:
                assert len(scan_from_message(turn_of(n_beams, step, last), "base_link").ranges) == n_beams
    for n_beams in (0, math.floor(whole) - 4, math.floor(whole) // 2):
        with pytest.raises(ScanError, match=r"angle_max: got 3\.14|ranges: got none"):
            scan_from_message(turn_of(n_beams, step, math.pi), "base_link")


def test_a_scan_without_a_largest_range_has_none():
    scans = [scan_from_message(driver_message(range_max=most), "base_link") for most in (math.inf, 3.4e38, 1e6)]
    assert all((scan.ranges == 2.0).all() for scan in scans)
    state = State(7.0, np.zeros(2), np.zeros(2), 0.0)
    maps = [build_local_map(scan, state, Settings().robot, Settings().local_map) for scan in scans]
    assert maps[0].walls.tolist() == maps[1].walls.tolist() == maps[2].walls.tolist()
    np.testing.assert_array_equal(maps[0].border_points, maps[2].border_points)
    for limits in ({"range_max": math.nan}, {"range_min": math.inf, "range_max": math.inf}):
        with pytest.raises(ScanError, match=r"range_max.*finite"):
            scan_from_message(driver_message(**limits), "base_link")


@pytest.mark.parametrize(
    ("fields", "taken", "expected"),
    [
        ({"time_increment": 0.0, "scan_time": -1.0}, {}, "scan_time: got -1"),
        ({"time_increment": math.nan}, {}, "time_increment: got nan"),
        ({"time_increment": math.nan, "scan_time": -5.0}, {"instant": True}, ""),
        ({"time_increment": 2.5e-4, "scan_time": math.nan}, {}, ""),
    ],
)
def test_times_of_a_scan_that_cannot_be_are_named_and_not_read_where_it_is_of_one_moment(fields, taken, expected):
    message, taken = driver_message(**fields), ScanInput(**taken)
    if not expected:
        assert (scan_from_message(message, "base_link", taken).time_increment == 0.0) == taken.instant
        return
    with pytest.raises(ScanError, match=expected):
        scan_from_message(message, "base_link", taken)


@pytest.mark.parametrize(
    ("ranges", "taken", "share"),
    [
        ([0.0, 2.0, 2.0, 2.0, 2.0], {}, "20%"),
        ([0.01, 0.0, 2.0, 2.0, 2.0], {"codes_below": 0.02}, "40%"),
        ([0.0, 2.0, 2.0, 2.0, 2.0], {"zero": "lost"}, ""),
        # codes other than 0
        ([0.001, 0.05, 2.0, 2.0, 2.0], {}, "40%"),
        ([0.02, 0.01, 2.0, 2.0], {"zero": "lost", "codes_below": 0.02}, ""),
        # the robot's own parts, beams 0.0 to 1.0 rad
        ([0.0, 0.0, 0.05, 2.0, 2.0, 2.0], {"masked_angles": (-0.1, 1.1)}, ""),
        ([0.0, 0.0, 0.05, 0.0, 2.0, 2.0], {"masked_angles": (-0.1, 1.1)}, "33%"),
        ([0.0, *[2.0] * 30], {}, ""),
        ([-math.inf, math.nan, 2.0, 2.0], {}, ""),
        ([], {}, ""),
    ],
)
def test_many_ranges_below_range_min_are_suspicious(ranges, taken, share):
    said = suspiciously_near(LaserScan(ranges=ranges, range_min=0.1, angle_increment=0.5), ScanInput(**taken))
    assert said.startswith(share)
    assert ("scan.zero" in said) == bool(share)


def test_the_frame_of_scans():
    message = c.scan_to_message(Scan(0.0, 0.0, 0.1, 0.02, 5.0, np.full(5, 1.0)), "laser")
    assert len(scan_from_message(message, "base_link", ScanInput(frame="laser")).ranges) == 5
    for taken, words in ((ScanInput(), "'laser', expected 'base_link'"), (ScanInput(frame="front"), "scan.frame")):
        with pytest.raises(ScanError, match=words):
            scan_from_message(message, "base_link", taken)


def driver_message(**fields):
    """As a driver of a spinning LIDAR sends it: 400 beams of a turn of 0.1 s."""
    step = 2 * math.pi / 400
    message = LaserScan(angle_min=-math.pi, angle_max=math.pi - step, angle_increment=step)
    message.range_min, message.range_max = 0.15, 8.0
    message.header.frame_id = "base_link"
    message.header.stamp.sec = 7
    message.scan_time, message.time_increment = 0.1, 0.1 / 400
    message.ranges, message.intensities = [2.0] * 400, [40.0] * 400
    for name, value in fields.items():
        setattr(message, name, value)
    return message


def instants(scan):
    return scan.stamp + scan.time_increment * np.arange(len(scan.ranges))


def test_drivers_that_turn_the_order_of_their_beams_or_stamp_the_end_of_the_sweep():
    scan = scan_from_message(driver_message(), "base_link", ScanInput(backwards=True))
    np.testing.assert_allclose(instants(scan), 7.0 + 0.1 / 400 * np.arange(400)[::-1], atol=1e-6)
    scan = scan_from_message(driver_message(), "base_link", ScanInput(stamp_offset=-0.1))
    np.testing.assert_allclose(instants(scan)[[0, -1]], [6.9, 7.0 - 0.1 / 400], atol=1e-6)


def test_a_driver_that_gives_the_time_of_a_turn_alone():
    for first, last in ((0.0, math.pi), (math.pi, 0.0)):  # counter-clockwise and clockwise
        half = {"angle_min": first, "angle_max": last, "angle_increment": (last - first) / 199, "ranges": [2.0] * 200}
        scan = scan_from_message(driver_message(time_increment=0.0, **half), "base_link")
        assert instants(scan)[-1] - 7.0 == pytest.approx(0.05, rel=0.01)
    assert scan_from_message(driver_message(time_increment=0.0, scan_time=0.0), "base_link").time_increment == 0.0


HOKUYO = read_parameters(CONFIG / "lidar_urg_node2.yaml")
READINGS = st.one_of(st.sampled_from([0.0, 0.001, 0.005, 0.018, 0.019, 0.02, math.nan, math.inf]), st.floats(0.02, 8.0))


@given(st.lists(READINGS, max_size=40), st.sampled_from(["near", "lost", "free"]))
@FEW
def test_codes_that_come_as_distances_mean_what_zero_means(readings, zero):
    message = driver_message(ranges=[*readings, *[2.0] * (400 - len(readings))], range_min=0.02)
    taken = ScanInput(zero=zero, codes_below=HOKUYO["scan.codes_below"])
    told = np.array(message.ranges)
    is_code = told < 0.0195
    meant = {"near": -math.inf, "lost": math.nan, "free": math.inf}[zero]
    plain = scan_from_message(message, "base_link").ranges
    np.testing.assert_array_equal(
        scan_from_message(message, "base_link", taken).ranges, np.where(is_code, meant, plain)
    )


RPLIDAR = Settings().with_values(
    read_parameters(CONFIG / "lidar_sllidar.yaml") | {"scan.frame": "", "scan.backwards": False}
)
"""Its shipped set; without what it says of frame and order, the message here being another."""


def rplidar(ranges):
    """As sllidar_ros2 sends it: +Inf for what the device gives as 0, as all that is nearer than range_min."""
    ranges = np.array(ranges)
    return driver_message(ranges=np.where((ranges < 0.15) | (ranges > 8.0), np.inf, ranges).tolist())


def test_what_infinite_ranges_and_those_of_zero_mean():
    message = driver_message(ranges=[math.inf, 9.0, 0.1, math.nan, 0.0, 8.0] + [2.0] * 394)
    for taken, first, last in (
        (ScanInput(infinite="free", zero="near"), math.inf, -math.inf),
        (ScanInput(infinite="lost", zero="lost"), math.nan, math.nan),
        (ScanInput(zero="free"), math.inf, math.inf),
    ):
        ranges = scan_from_message(message, "base_link", taken).ranges
        np.testing.assert_array_equal(ranges[:7], [first, math.nan, -math.inf, math.nan, last, first, 2.0])


@given(distance=st.floats(0.091, 0.149), place=st.integers(0, 399))
@FEW
def test_what_the_shipped_set_of_a_lidar_does_not_measure_close_by_is_not_free(distance, place):
    angles = -math.pi + 2 * math.pi / 400 * np.arange(400)
    ahead = np.cos(angles - angles[place])
    ranges = np.minimum(np.where(ahead > 0.0, distance / np.maximum(ahead, 1e-9), 2.0), 2.0)
    scan = scan_from_message(rplidar(ranges), "base_link", RPLIDAR.scan)
    state = State(7.0, np.zeros(2), np.zeros(2), 0.0)
    free = build_local_map(scan, state, RPLIDAR.robot, RPLIDAR.local_map).border_points
    towards = free @ [math.cos(angles[place]), math.sin(angles[place])]
    facing = towards > 0.5 * np.linalg.norm(free, axis=1)
    assert towards[facing].max(initial=0.0) < 0.5 * distance


def test_weak_ranges_are_lost_and_beams_that_met_nothing_are_not():
    message = driver_message(ranges=[2.0, math.inf, 1.0] + [2.0] * 397, intensities=[9.0, 0.0, 10.0] + [40.0] * 397)
    ranges = scan_from_message(message, "base_link", ScanInput(min_intensity=10.0)).ranges
    np.testing.assert_array_equal(ranges[:4], [math.nan, math.inf, 1.0, 2.0])
    assert scan_from_message(message, "base_link").ranges[0] == 2.0
    with pytest.raises(ScanError, match="intensities: got 0, expected 400"):
        scan_from_message(driver_message(intensities=[]), "base_link", ScanInput(min_intensity=10.0))


# ---- commands


@given(points, numbers)
@FEW
def test_command(velocity, yaw_rate):
    command = Command(velocity, yaw_rate, "free_space", np.zeros(2))
    back, rate = r.velocity_from_twist(sent(c.command_to_twist(command)))
    np.testing.assert_array_equal(back, velocity)
    assert rate == yaw_rate


def test_only_a_command_of_zeros_asks_for_rest():
    parts = itertools.product((0.0, -0.0, 1e-9, -0.5, math.nan, math.inf), repeat=3)
    for x, y, yaw_rate in parts:
        twist = c.command_to_twist(Command(np.array([x, y]), yaw_rate, "free_space", np.zeros(2)))
        assert c.asks_for_rest(twist) == (not any((x, y, yaw_rate)))


def test_a_parameter_chooses_the_type_of_a_command_and_its_twist_is_the_same():
    command = Command(np.array([0.3, -0.2]), 0.1, "free_space", np.zeros(2))
    for stamped, kind in ((False, Twist), (True, TwistStamped)):
        chosen = Settings().with_values({"controller.stamped_cmd_vel": stamped, "frames.base": "puck"})
        message = command_to_message(command, 12.5, chosen)
        assert command_type(chosen.controller) is type(message) is kind
        twist = twist_of(message)
        assert (twist.linear.x, twist.linear.y, twist.angular.z) == (0.3, -0.2, 0.1)
    assert (r.seconds_from_stamp(message.header.stamp), message.header.frame_id) == (12.5, "puck")
