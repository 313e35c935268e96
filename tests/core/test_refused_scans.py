"""What planner and controller make of scans that cannot be true, and how they come back to drive by scans."""

from dataclasses import replace

import numpy as np
import pytest

from collplan_core.deadline import never
from collplan_core.goal import EXECUTING, Goal
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.loop.refusals import Refusals
from collplan_core.loop.scan_trust import PAUSE, ScanTrust
from collplan_core.loop.sensors import Sensors
from collplan_core.parameters import Settings
from loop_scenes import at, scan_at

SETTINGS = Settings()
STEP = 0.05
MISSING = "missing in 100%"


class Drive:
    """A robot that drives along a hall at 0.6 m/s, and what it makes of its scans."""

    def __init__(self) -> None:
        self.refusals = Refusals()
        self.sensors = Sensors(0.5, self.refusals)
        self.stamp = 1.0

    def see(self, n: int = 1, blind: bool = False, leap: float = 0.0) -> None:
        """The next n poses and scans."""
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
def drive() -> Drive:
    drive = Drive()
    drive.see(10)
    assert drive.reason == ""
    return drive


def test_a_single_scan_is_left_out_and_two_running_stop_the_robot_with_the_reason(drive):
    before = drive.sensors.newest_placed()[0].stamp
    drive.see(blind=True)
    assert (drive.reason, drive.refusals["scan"]) == ("", 1)
    assert drive.sensors.newest_placed()[0].stamp == before
    drive.see()
    assert drive.sensors.newest_placed()[0].stamp > before
    drive.see(2, blind=True)
    assert MISSING in drive.reason


def test_it_goes_on_a_pause_after_the_last_refusal(drive):
    drive.see(4, blind=True)
    drive.see(round(PAUSE / STEP) - 1)
    assert MISSING in drive.reason
    drive.see(2)
    assert drive.reason == ""


def test_a_world_that_changed_holds_it_until_a_person_says_so(drive):
    drive.see(40, blind=True)
    assert MISSING in drive.reason
    drive.sensors.forget_scans()
    drive.see(blind=True)
    assert drive.reason == ""


def test_a_gap_or_leap_of_the_poses_makes_no_scan_believed():
    for seen, gap, leap in ((0, 0.3, 0.0), (1, 0.3, 0.0), (3, 2.0, 0.0), (0, 0.0, 1.0), (3, 0.0, 1.0)):
        drive = Drive()
        drive.see(10)
        drive.see(seen, blind=True)
        drive.stamp += gap
        drive.see(2, blind=True, leap=leap)
        assert MISSING in drive.reason, (seen, gap, leap)


def test_a_scan_of_a_clock_that_is_ahead_is_refused_and_does_not_keep_the_last_one_fresh(drive):
    ahead = scan_at(at(drive.stamp + 0.4))
    drive.sensors.take_scan(ahead, drive.stamp, SETTINGS)
    assert drive.reason == ""
    assert all(part in drive.refusals.newest for part in ("0.40 s", "0.15 s"))
    for _ in range(6):
        drive.stamp += STEP
        drive.sensors.take_pose(at(drive.stamp), drive.stamp, SETTINGS)
        drive.sensors.take_scan(scan_at(at(drive.stamp + 0.4)), drive.stamp, SETTINGS)
    assert "0.40 s before" in drive.reason


def test_a_late_scan_is_refused_and_does_not_keep_the_last_one_fresh(drive):
    late = scan_at(at(drive.stamp - 0.3))
    for _ in range(3):
        drive.sensors.take_scan(late, drive.stamp, SETTINGS)
    assert drive.reason == ""
    assert all(part in drive.refusals.newest for part in ("0.30 s", "0.25 s"))
    state = at(drive.stamp + 0.14)
    drive.sensors.take_pose(state, state.stamp, SETTINGS)
    assert drive.sensors.why_stale(state.stamp, SETTINGS.limits) == ""
    assert drive.sensors.why_stale(state.stamp + 0.12, SETTINGS.limits) != ""


def test_a_scan_waits_for_its_pose(drive):
    ahead = at(drive.stamp + 0.02, 0.6 * (drive.stamp - 0.98))
    drive.sensors.take_scan(scan_at(ahead), drive.stamp, SETTINGS)
    assert drive.sensors.newest_placed()[0].stamp == drive.stamp
    drive.sensors.take_pose(ahead, drive.stamp + 0.02, SETTINGS)
    assert drive.sensors.newest_placed()[0].stamp == ahead.stamp


def test_each_stop_within_a_while_lasts_twice_as_long_as_the_one_before():
    trust, now, pauses = ScanTrust(), 0.0, []
    for _ in range(4):
        trust.refused("odd", now)
        trust.refused("odd", now)
        trust.believed()
        pause = next(k for k in range(10_000) if not trust.why_not(now + 0.01 * k)) * 0.01
        pauses.append(pause)
        now += pause + 1.0
    np.testing.assert_allclose(pauses, [PAUSE, 2 * PAUSE, 4 * PAUSE, 8 * PAUSE], atol=0.011)


def test_planner_and_controller_begin_anew_with_a_new_goal(monkeypatch):
    forgotten = []
    monkeypatch.setattr(Sensors, "forget_scans", lambda sensors: forgotten.append(sensors))
    planner, controller = PlannerLoop(SETTINGS, lambda settings: never), ControllerLoop(SETTINGS)
    for n, identity in enumerate((b"one", b"two"), 1):
        planner.take_goal(identity, np.array([2.0, 0.0]), 1.0)
        assert len(forgotten) == 2 * n - 1
        for stamp in (0.5, 0.6):
            controller.take_goal(Goal(identity, stamp, np.zeros(2), EXECUTING))
        assert len(forgotten) == 2 * n
