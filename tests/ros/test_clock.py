"""The two times: steady or simulated local time, and the poses' clock."""

import math
from types import SimpleNamespace

from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from collplan_core.ages import PosesClock
from collplan_ros.messages.conversions import stamp_from_seconds
from collplan_ros.messages.qos import NEWEST
from collplan_ros.node_kit.clock import IN_STEP, call_each_period, keep_step, local_clock, seconds


@given(st.floats(0.0, 2e9), st.floats(0.0, 1e6), st.floats(0.0, 10.0))
def test_poses_clock_runs_on_between_poses(stamp, local, later):
    clock = PosesClock()
    clock.received(stamp, local)
    assert abs(clock.now(local + later) - (stamp + later)) < 1e-6
    assert abs(clock.age(local + later) - later) < 1e-6


def test_poses_clock_before_the_first_pose():
    assert PosesClock().now(3.0) is None
    assert PosesClock().age(3.0) == math.inf


def test_local_clock_follows_simulated_time(ros):
    node = ros.make(lambda **kwargs: Node("simulated", **kwargs), {"use_sim_time": True})
    ticks = []
    clock = local_clock(node)
    node.create_timer(1.0, lambda: ticks.append(seconds(clock)), clock=clock)
    publisher = ros.publisher(Clock, "/clock", NEWEST)
    for stamp in (100.0, 100.5, 101.5):
        publisher.publish(Clock(clock=stamp_from_seconds(stamp)))
        assert ros.wait_until(lambda stamp=stamp: seconds(clock) == stamp and ticks)
    assert ros.wait_until(lambda: 101.5 in ticks)
    assert 100.5 not in ticks


class TimerAsRclHasIt:
    """Calls are due at `next`, each a period after the one before; times are in ns."""

    def __init__(self, period, callback):
        self.timer_period_ns, self.callback, self.now, self.next = round(1e9 * period), callback, 0, 0

    def time_until_next_call(self):
        return self.next - self.now

    def reset(self):
        self.next = self.now + self.timer_period_ns

    def call(self, now):
        self.now = now
        self.next += self.timer_period_ns
        self.callback()


@given(st.integers(0, 49), st.integers(0, 49))
def test_a_call_too_many_acts_on_nothing_and_moves_no_other_call(late, later):
    acted = []
    node = SimpleNamespace(create_timer=lambda period, callback, clock: TimerAsRclHasIt(period, callback))
    timer = call_each_period(node, 0.05, lambda: acted.append(timer.now), None)
    now = late * 10**6
    timer.call(now)
    timer.call(max(now, later * 10**6))
    assert acted == [now]
    assert (timer.next, timer.timer_period_ns) == (50 * 10**6, 50 * 10**6)


@given(left=st.integers(1, 200), lead=st.integers(0, 49), own=st.sampled_from([50, 100, 200]))
@settings(max_examples=100)
def test_a_timer_in_step_with_another_calls_before_it(left, lead, own):
    timer = TimerAsRclHasIt(1e-3 * own, None)
    timer.now, timer.next = 10**9, 10**9 + left * 10**6
    keep_step(timer, 0.05, 1e-3 * lead)
    late = (timer.time_until_next_call() + lead * 10**6 + 25 * 10**6) % (50 * 10**6) - 25 * 10**6
    assert abs(late) <= IN_STEP
    assert timer.timer_period_ns == own * 10**6
    assert 0 < timer.time_until_next_call() <= (left + 50) * 10**6


def test_a_timer_with_another_period_keeps_its_own_step():
    timer = TimerAsRclHasIt(0.07, None)
    timer.next = 33 * 10**6
    keep_step(timer, 0.05, 0.02)
    assert timer.next == 33 * 10**6
