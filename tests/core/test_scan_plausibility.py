"""True scans are believed, scans that cannot be true are not; how planner and controller come back to drive by them."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.deadline import never
from collplan_core.goal import EXECUTING, Goal
from collplan_core.local_map.seen import seen_surfaces
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.input_gate import PAUSE, InputGate, Refusals, ScanGate
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.loop.sensed_scans import SensedScans
from collplan_core.parameters import ScanInput, Settings
from collplan_core.scan import Scan
from collplan_core.scans.filters import masked_beams, upside_down, used_scan
from collplan_core.scans.plausibility import NOWHERE, ScanMemory, judge_scan
from collplan_core.scans.remembered_walls import wall_of_each_beam
from collplan_core.scans.wall_lines import on_wall_lines, range_noise
from collplan_core.state import State
from collplan_core.worlds import parse_world
from collplan_core.worlds.raycast import simulate_scan
from loop_scenes import at, scan_at

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
    times = PERIOD * np.arange(n)
    return [State(t, np.array(begin) + t * np.array(velocity), np.array(velocity), yaw_rate * t) for t in times]


def scans_of(states, world=ROOM) -> list[Scan]:
    return [simulate_scan(world, state, SETTINGS.lidar) for state in states]


def standing_at(state: State, scan: Scan) -> np.ndarray:
    return np.tile([*state.position, state.yaw], (len(scan.ranges), 1))


def judged(states, scans, taken=SETTINGS.scan) -> list[str]:
    reasons, memory = [], ScanMemory()
    for state, scan in zip(states, scans, strict=True):
        masked, beams = masked_beams(scan, taken), standing_at(state, scan)
        seen = seen_surfaces(on_wall_lines(scan, range_noise(scan)), state)
        reason, memory = judge_scan(memory, scan, masked, beams, seen, state, SETTINGS.limits)
        reasons.append(reason)
    return reasons


def noisy(scan: Scan, random: np.random.Generator) -> Scan:
    """With the noise and the losses of a low-cost LIDAR."""
    ranges = np.maximum(scan.ranges + 0.012 * random.standard_normal(len(scan.ranges)), scan.range_min)
    return replace(scan, ranges=np.where(random.random(len(ranges)) < 0.02, np.nan, ranges))


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
    for share, first in ((0.5, 0), (0.5, 120), (0.5, 240), (1.0, 0)):
        states = drive()
        scans = scans_of(states)
        scans[-1] = empty(scans[-1], share, first)
        *before, reason = judged(states, scans)
        assert not any(before), (share, first)
        assert "missing" in reason, (share, first)


def test_beams_that_stay_blind_are_refused_wherever_the_robot_comes_to_rest():
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
    states = drive(velocity=(0.0, 0.0))
    assert judged(states, scans_of(states)) == [""] * len(states)
    states = drive()
    scans = scans_of(states)
    frozen = [*scans[:6], *(replace(scan, ranges=scans[5].ranges) for scan in scans[6:])]
    reasons = judged(states, frozen)
    assert not any(reasons[:6])
    assert all("last bit" in reason for reason in reasons[6:])


def turning(n: int = 21) -> list[State]:
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


def test_walls_hidden_since_by_a_parallel_one_make_no_scan_late():
    """Behind the robot, as far as a scan of 0.5 s ago would show the nearer wall; of the last 0.2 s none is hidden."""
    state = State(1.0, np.array([1.5, 0.5]), np.array([0.0, 1.0]), 0.0)
    scan = simulate_scan(DOOR, state, SETTINGS.lidar)
    beams, masked = standing_at(state, scan), np.zeros(len(scan.ranges), bool)
    seen = seen_surfaces(on_wall_lines(scan, range_noise(scan)), state)
    shown = wall_of_each_beam(seen, scan, state.position)
    shown = shown[~np.isnan(shown[:, 0])]
    behind = shown[shown[:, 3] > 0.9]
    hidden = behind - [0.0, 0.5, 0.0, 0.0, 0.0]
    for newest, late in ((shown, False), (hidden, True)):
        memory = ScanMemory(walls=(*((t, hidden) for t in (0.1, 0.3, 0.5, 0.7)), (0.9, newest)))
        reason, _ = judge_scan(memory, scan, masked, beams, seen, state, SETTINGS.limits)
        assert ("before its stamp" in reason) == late, reason


LEGS = ((-0.5, 0.3), (-0.5, -0.6), (0.2, 0.7), (0.6, -0.6), (0.9, 0.5))
"""Each 0.2 m wide: together they hide a third of the walls."""


def gone(speed: float, legs, moved=NOWHERE) -> str:
    squares = [[[x - 0.1, y - 0.1], [x + 0.1, y - 0.1], [x + 0.1, y + 0.1], [x - 0.1, y + 0.1]] for x, y in legs]
    empty, full = {"name": "hall", "bounds": [-2.0, -2.0, 2.0, 2.0]}, {"polygons": squares}
    before, after = parse_world(empty | full, "hall"), parse_world(empty, "hall")
    reason, memory = "", ScanMemory()
    for k, state in enumerate(drive((0.0, 0.0), (speed, 0.0))):
        assert reason == "", k
        scan = simulate_scan(after if k == 10 else before, state, SETTINGS.lidar)
        beams, masked, seen = standing_at(state, scan), np.zeros(len(scan.ranges), bool), seen_surfaces(scan, state)
        reason, memory = judge_scan(memory, scan, masked, beams, seen, state, SETTINGS.limits, moved)
    return reason


def test_who_walks_off_is_no_wall_to_a_robot_at_rest_but_nothing_may_vanish_before_one_that_drives():
    discs = np.array([[x, y, 0.1] for x, y in LEGS])
    assert gone(0.0, LEGS) == ""
    assert "missing" in gone(0.4, LEGS)
    assert gone(0.4, LEGS, discs) == ""
    assert "missing" in gone(0.4, LEGS, discs + np.array([9.0, 0.0, 0.0]))


def test_what_is_seen_of_a_wall_between_posts_is_a_wall():
    row = [(0.8, 0.3 * k) for k in range(-4, 5)]
    assert "missing" in gone(0.0, row)
    assert gone(0.0, row[::4]) == ""


def test_walls_older_than_a_second_do_not_count():
    states = drive(velocity=(0.0, 0.0), n=40)
    reasons = judged(states, scans_of([replace(state, yaw=0.5 * (k >= 10)) for k, state in enumerate(states)]))
    assert all("missing" in reason for reason in reasons[10:25])
    assert not any(reasons[31:])


def test_open_beams_beside_a_wall_met_flatly_may_have_met_it():
    """A wall 0.4 m to the left gives nothing back from 2 m on, 12 degrees; at 4 m a beam is within 6 degrees of it."""
    world = parse_world({"name": "long", "bounds": [-9.0, -3.5, 9.0, 0.4]}, "long")
    scan = simulate_scan(world, at(1.0), replace(SETTINGS.lidar, range_max=20.0))
    sine = np.sin(scan.angles)
    for beyond, of in ((2.0, 4.0), (0.8, 0.8)):
        far = (sine > 0.0) & (scan.ranges > beyond)
        faded = seen_surfaces(replace(scan, ranges=np.where(far, np.inf, scan.ranges)), at(1.0)).fades
        np.testing.assert_array_equal(faded, far & (scan.ranges <= of))


STEP = 0.05
MISSING, BLIND = "missing in 100%", "100% of the beams that missed walls still show nothing"


class Drive:
    """A robot that drives along a hall at 0.6 m/s, and what it makes of its scans."""

    def __init__(self) -> None:
        self.refusals = Refusals()
        self.sensors = InputGate(SensedScans(0.5), self.refusals)
        self.stamp = 1.0

    def see(self, n: int = 1, blind: bool = False, leap: float = 0.0) -> None:
        for _ in range(n):
            self.stamp += STEP
            state = replace(at(self.stamp, 0.6 * (self.stamp - 1.0) + leap), velocity=np.array([0.6, 0.0]))
            self.sensors.take_pose(state, self.stamp, SETTINGS)
            scan = scan_at(state)
            if blind:
                scan = replace(scan, ranges=np.full(len(scan.ranges), np.inf))
            self.sensors.take_scan(scan, self.stamp, SETTINGS)

    @property
    def reason(self) -> str:
        return self.sensors.why_stale(self.stamp, SETTINGS.limits)


@pytest.fixture
def driven() -> Drive:
    driven = Drive()
    driven.see(10)
    assert driven.reason == ""
    return driven


def test_a_single_scan_is_left_out_and_two_running_stop_the_robot_with_the_reason(driven):
    before = driven.sensors.sensed.newest_placed()[0].stamp
    driven.see(blind=True)
    assert (driven.reason, driven.refusals["scan"]) == ("", 1)
    assert driven.sensors.sensed.newest_placed()[0].stamp == before
    driven.see()
    assert driven.sensors.sensed.newest_placed()[0].stamp > before
    driven.see(2, blind=True)
    assert MISSING in driven.reason


def test_a_world_that_changed_holds_it_until_a_person_says_so(driven):
    driven.see(40, blind=True)
    assert BLIND in driven.reason
    driven.sensors.forget_scans()
    driven.see(blind=True)
    assert driven.reason == ""


def test_a_repeated_scan_is_none_and_stops_once_the_last_one_is_too_old(driven):
    repeated = scan_at(at(driven.stamp, 0.6 * (driven.stamp - 1.0)))
    for k in range(10):
        driven.stamp += STEP
        state = replace(at(driven.stamp, 0.6 * (driven.stamp - 1.0)), velocity=np.array([0.6, 0.0]))
        driven.sensors.take_pose(state, driven.stamp, SETTINGS)
        driven.sensors.take_scan(replace(repeated, stamp=driven.stamp), driven.stamp, SETTINGS)
        assert k > 3 or driven.reason == "", k
    assert "last bit" in driven.reason
    assert "inspect on this run's folder" in driven.reason
    assert driven.refusals["scan"] == 0
    driven.see()
    assert driven.reason == ""


def test_a_gap_or_leap_of_the_poses_makes_no_scan_believed():
    for seen, gap, leap in ((0, 0.3, 0.0), (1, 0.3, 0.0), (3, 2.0, 0.0), (0, 0.0, 1.0), (3, 0.0, 1.0)):
        driven = Drive()
        driven.see(10)
        driven.see(seen, blind=True)
        driven.stamp += gap
        driven.see(2, blind=True, leap=leap)
        assert (BLIND if gap > 1.0 else MISSING) in driven.reason, (seen, gap, leap)


def test_a_scan_of_a_clock_that_is_ahead_is_refused_and_does_not_keep_the_last_one_fresh(driven):
    ahead = scan_at(at(driven.stamp + 0.4))
    driven.sensors.take_scan(ahead, driven.stamp, SETTINGS)
    assert driven.reason == ""
    assert all(part in driven.refusals.newest for part in ("0.40 s", "0.15 s"))
    for _ in range(6):
        driven.stamp += STEP
        driven.sensors.take_pose(at(driven.stamp), driven.stamp, SETTINGS)
        driven.sensors.take_scan(scan_at(at(driven.stamp + 0.4)), driven.stamp, SETTINGS)
    assert "0.40 s before" in driven.reason


def test_a_late_scan_is_refused_and_does_not_keep_the_last_one_fresh(driven):
    late = scan_at(at(driven.stamp - 0.3))
    for _ in range(3):
        driven.sensors.take_scan(late, driven.stamp, SETTINGS)
    assert driven.reason == ""
    assert all(part in driven.refusals.newest for part in ("0.30 s", "0.25 s"))
    state = at(driven.stamp + 0.14)
    driven.sensors.take_pose(state, state.stamp, SETTINGS)
    assert driven.sensors.why_stale(state.stamp, SETTINGS.limits) == ""
    assert driven.sensors.why_stale(state.stamp + 0.12, SETTINGS.limits) != ""


def test_a_scan_waits_for_its_pose(driven):
    ahead = at(driven.stamp + 0.02, 0.6 * (driven.stamp - 0.98))
    driven.sensors.take_scan(scan_at(ahead), driven.stamp, SETTINGS)
    assert driven.sensors.sensed.newest_placed()[0].stamp == driven.stamp
    driven.sensors.take_pose(ahead, driven.stamp + 0.02, SETTINGS)
    assert driven.sensors.sensed.newest_placed()[0].stamp == ahead.stamp


def test_each_stop_within_a_while_lasts_twice_as_long_as_the_one_before():
    trust, now, pauses = ScanGate(), 0.0, []
    for _ in range(4):
        trust.reject("odd", now)
        trust.reject("odd", now)
        trust.accept()
        pause = next(k for k in range(10_000) if not trust.why_not(now + 0.01 * k)) * 0.01
        pauses.append(pause)
        now += pause + 1.0
    np.testing.assert_allclose(pauses, [PAUSE, 2 * PAUSE, 4 * PAUSE, 8 * PAUSE], atol=0.011)


def test_planner_and_controller_begin_anew_with_a_new_goal(monkeypatch):
    forgotten = []
    monkeypatch.setattr(InputGate, "forget_scans", lambda sensors: forgotten.append(sensors))
    planner, controller = PlannerLoop(SETTINGS, lambda settings: never), ControllerLoop(SETTINGS)
    for n, identity in enumerate((b"one", b"two"), 1):
        planner.take_goal(identity, np.array([2.0, 0.0]), 1.0)
        assert len(forgotten) == 2 * n - 1
        for stamp in (0.5, 0.6):
            controller.take_goal(Goal(identity, stamp, np.zeros(2), EXECUTING))
        assert len(forgotten) == 2 * n


@pytest.mark.parametrize("turn", [0.0, 0.1, -0.2, 0.3333, 30.0, -0.4])
def test_a_scan_that_takes_longer_than_it_may_is_refused_by_its_field(driven, turn):
    scan = scan_at(at(driven.stamp))
    driven.sensors.take_scan(replace(scan, time_increment=turn / len(scan.ranges)), driven.stamp, SETTINGS)
    words = ("time_increment or scan_time", "limits.scan_age 0.25", "scan.instant")
    assert [word in driven.refusals.newest for word in words] == [abs(turn) > 0.25] * 3, driven.refusals.newest
