"""True scans are believed wherever the robot drives; scans that cannot be true after those before them are not."""

import math
from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.parameters import ScanInput, Settings
from collplan_core.scan import Scan
from collplan_core.sensing.beam_poses import beam_poses
from collplan_core.sensing.pose_history import PoseHistory
from collplan_core.sensing.scan_filters import masked_beams, upside_down, used_scan
from collplan_core.sensing.scan_plausibility import ScanMemory, judge_scan
from collplan_core.state import State
from collplan_core.worlds import parse_world
from collplan_core.worlds.raycast import simulate_scan

SETTINGS = Settings()
PERIOD = 0.05
ROOM = parse_world(
    {
        "name": "room",
        "bounds": [0.0, 0.0, 3.0, 2.0],
        "polygons": [[[1.0, 0.0], [1.1, 0.0], [1.1, 1.2], [1.0, 1.2]]],
        "circles": [{"center": [2.0, 1.2], "radius": 0.1}],
    },
    "room",
)
DOOR = parse_world(
    {
        "name": "door",
        "bounds": [0.0, 0.0, 2.4, 6.0],
        "polygons": [
            [[0.0, 0.9], [0.3, 0.9], [0.3, 1.0], [0.0, 1.0]],
            [[0.7, 0.9], [2.4, 0.9], [2.4, 1.0], [0.7, 1.0]],
        ],
    },
    "door",
)


def drive(begin=(0.3, 0.4), velocity=(0.0, 0.6), n=11, yaw_rate=0.0) -> list[State]:
    """The robot, one state a scan."""
    times = PERIOD * np.arange(n)
    return [State(t, np.array(begin) + t * np.array(velocity), np.array(velocity), yaw_rate * t) for t in times]


def scans_of(states, world=ROOM) -> list[Scan]:
    return [simulate_scan(world, state, SETTINGS.lidar) for state in states]


def standing_at(state: State, scan: Scan) -> np.ndarray:
    return np.tile([*state.position, state.yaw], (len(scan.ranges), 1))


def judged(states, scans, taken=SETTINGS.scan) -> list[str]:
    """Why each scan is not believed."""
    reasons, memory = [], ScanMemory()
    for state, scan in zip(states, scans, strict=True):
        masked, beams = masked_beams(scan, taken), standing_at(state, scan)
        reason, memory = judge_scan(memory, scan, masked, beams, state.velocity, SETTINGS.limits)
        reasons.append(reason)
    return reasons


def noisy(scan: Scan, random: np.random.Generator) -> Scan:
    """With the noise and the losses of a low-cost LIDAR."""
    ranges = np.maximum(scan.ranges + 0.012 * random.standard_normal(len(scan.ranges)), scan.range_min)
    return replace(scan, ranges=np.where(random.random(len(ranges)) < 0.02, np.nan, ranges))


@settings(max_examples=25, deadline=None)
@given(
    st.floats(0.2, 0.8), st.floats(0.2, 0.6), st.floats(-math.pi, math.pi), st.floats(0.0, 1.2), st.integers(0, 2**31)
)
def test_true_scans_are_believed(x, y, course, speed, seed):
    random = np.random.default_rng(seed)
    velocity = speed * np.array([0.2 * math.cos(course), abs(math.sin(course))])
    states = drive((x, y), velocity, yaw_rate=random.uniform(-2.0, 2.0))
    true = scans_of(states)
    assert judged(states, true) == [""] * len(states)
    shaken = [
        replace(
            s, position=s.position + 0.002 * random.standard_normal(2), yaw=s.yaw + 0.005 * random.standard_normal()
        )
        for s in states
    ]
    assert judged(shaken, [noisy(scan, random) for scan in true]) == [""] * len(states)


def empty(scan: Scan, share: float, first: int) -> Scan:
    ranges = scan.ranges.copy()
    ranges[(first + np.arange(round(share * len(ranges)))) % len(ranges)] = np.inf
    return replace(scan, ranges=ranges)


def test_walls_do_not_vanish():
    for share, first in ((0.5, 0), (0.5, 60), (0.5, 120), (0.5, 180), (0.5, 240), (0.5, 300), (1.0, 0)):
        states = drive()
        scans = scans_of(states)
        scans[-1] = empty(scans[-1], share, first)
        *before, reason = judged(states, scans)
        assert not any(before), (share, first)
        assert "missing" in reason, (share, first)


def test_beams_that_stay_blind_are_refused_wherever_the_robot_comes_to_rest():
    """Half of the beams, while it brakes in a door, beyond which other walls are in sight."""
    for first in range(0, 360, 120):
        driven = drive((0.5, 0.5), (0.0, 0.6), 15)
        rest = [replace(driven[-1], stamp=driven[-1].stamp + PERIOD * (k + 1), velocity=np.zeros(2)) for k in range(10)]
        states = driven + rest
        true = scans_of(states, DOOR)
        scans = [empty(scan, 0.5, first) if k >= 8 else scan for k, scan in enumerate(true)]
        reasons = judged(states, scans)
        assert not any(reasons[:8]), first
        assert all(reasons[8:]), first
        assert judged(states, [*scans[:-1], true[-1]])[-1] == "", first


def test_ranges_that_repeat_are_refused_once_the_robot_has_moved():
    states = drive()
    scans = scans_of(states)
    frozen = [*scans[:6], *(replace(scan, ranges=scans[5].ranges) for scan in scans[6:])]
    reasons = judged(states, frozen)
    assert not any(reasons[:6])
    assert all("last bit" in reason for reason in reasons[6:])


def test_ranges_that_repeat_while_the_robot_stands_are_believed():
    states = drive(velocity=(0.0, 0.0))
    assert judged(states, scans_of(states)) == [""] * len(states)


def turning(n: int = 21) -> list[State]:
    """A robot that turns on the spot: all walls pass behind a mask."""
    return drive(velocity=(0.0, 0.0), n=n, yaw_rate=3.0)


def test_walls_that_pass_behind_a_mask_are_not_missing():
    for mask, mirrored in (((2.0, -2.0), False), ((-0.5, 0.5), True), ((-3.0, -1.5, 0.1, 1.4), True)):
        taken, states = ScanInput(masked_angles=mask, mirrored=mirrored), turning()
        scans = [used_scan(upside_down(scan) if mirrored else scan, taken) for scan in scans_of(states)]
        assert all(np.isnan(scan.ranges).any() for scan in scans), mask
        assert judged(states, scans, taken) == [""] * len(states), mask


def test_beams_beside_a_mask_that_are_lost_or_show_nothing_are_told():
    taken, states = ScanInput(masked_angles=(2.0, -2.0)), turning()
    true = scans_of(states)
    for wrong, reason in ((np.inf, "missing"), (np.nan, "lost")):
        ranges = np.where(np.cos(true[-1].angles) > 0.1, wrong, true[-1].ranges)
        scans = [used_scan(scan, taken) for scan in [*true[:-1], replace(true[-1], ranges=ranges)]]
        assert reason in judged(states, scans, taken)[-1]


def test_the_share_of_lost_beams_is_one_of_those_that_are_not_masked():
    (state,) = drive(n=1)
    (scan,) = scans_of([state])
    for taken in (ScanInput(), ScanInput(masked_angles=(0.5, -0.5))):
        for share, refused in ((0.45, False), (0.55, True)):
            lost = np.arange(len(scan.ranges)) % 20 < 20 * share - 1e-9
            used = used_scan(replace(scan, ranges=np.where(lost, np.nan, scan.ranges)), taken)
            assert bool(judged([state], [used], taken)[0]) == refused, (taken, share)


def test_a_scan_of_a_while_ago_is_refused():
    for behind, speed in ((4, 0.5), (4, 1.2), (10, 1.2)):
        states = drive((0.3, 0.2), (0.0, speed), 13)
        scans = scans_of(states)
        scans[-1] = replace(scans[-1 - behind], stamp=scans[-1].stamp)
        *before, reason = judged(states, scans)
        assert not any(before), (behind, speed)
        assert reason, (behind, speed)


def test_beams_may_run_clockwise_and_cover_a_part_of_the_turn():
    for keep in [slice(None), slice(60, 300)]:
        states = drive()
        true = scans_of(states)
        increment = true[0].angle_increment
        turned = [
            replace(
                scan,
                ranges=scan.ranges[keep][::-1],
                angle_min=scan.angles[keep][-1],
                angle_increment=-increment,
            )
            for scan in true
        ]
        assert judged(states, turned) == [""] * len(states), keep
        turned[-1] = empty(turned[-1], 1.0, 0)
        assert "missing" in judged(states, turned)[-1], keep


def test_each_beam_has_the_pose_of_its_own_instant():
    poses = PoseHistory(1.0)
    for state in drive(n=5, yaw_rate=1.0):
        poses.add(state)
    scan = replace(scans_of(drive(n=1))[0], stamp=0.1, time_increment=0.2 / 360)
    centre = ScanInput()
    for way in (1.0, -1.0):
        beams = beam_poses(replace(scan, time_increment=way * 0.1 / 360), poses, centre)
        np.testing.assert_allclose(beams[180], [0.3, 0.4 + 0.6 * (0.1 + way * 0.05), 0.1 + way * 0.05], atol=1e-9)
    # the newest pose is of 0.2 s
    assert beam_poses(scan, poses, centre) is None
    instant = beam_poses(replace(scan, time_increment=0.0), poses, centre)
    np.testing.assert_allclose(instant[270], [0.3, 0.46, 0.1], atol=1e-9)
    assert beam_poses(replace(scan, stamp=0.3), poses, centre) is None
