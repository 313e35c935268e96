"""Gaps in a node's steady timer, and what queued up in them."""

import math
import time

import rclpy
from hypothesis import given
from hypothesis import strategies as st
from std_msgs.msg import String

from collplan_core.ages import StallGuard
from collplan_ros.messages.qos import EVENT, LATCHED
from collplan_ros.node_kit.backlog import Backlog
from collplan_ros.node_kit.inputs import STATE, Inputs

STALL = 0.3
"""Longer than what a guard lets pass [s]."""


@given(begin=st.floats(0.0, 1e6), steps=st.lists(st.floats(0.0, 0.4), max_size=30), limit=st.floats(0.05, 0.3))
def test_a_guard_tells_each_gap_beyond_its_limit_and_no_other(begin, steps, limit):
    guard, now = StallGuard(limit), begin
    assert not guard.tick(now)
    gaps = []
    for step in steps:
        before, now = now, now + step
        longer = now - before > limit
        assert guard.tick(now) == longer
        gaps += [(now - before, now)] if longer else []
        assert (guard.gap, guard.ended) == (gaps[-1] if gaps else (0.0, -math.inf))
        assert guard.count == len(gaps)


class Listener:
    def __init__(self, ros):
        self.node = ros.add(rclpy.create_node("listener", context=ros.context))
        self.backlog = Backlog(self.node)
        inputs = Inputs(self.node, backlog=self.backlog)
        self.heard, self.states, self.news = [], [], []
        inputs.listen(String, "stream", lambda message: self.heard.append(message.data), EVENT)
        inputs.listen(String, "state", lambda message: self.states.append(message.data), LATCHED, STATE)
        inputs.listen(String, "news", lambda message: self.news.append(message.data), EVENT, late_counts=True)


def test_what_queues_up_while_a_node_does_not_run_is_dropped_but_for_what_is_latched_or_counts_late(ros):
    listener = Listener(ros)
    stream, state = ros.publisher(String, "stream", EVENT), ros.publisher(String, "state", LATCHED)
    news = ros.publisher(String, "news", EVENT)
    assert ros.wait_until(lambda: news.publish(String(data="first")) or listener.news)
    # again where a stall of the machine has dropped it
    assert ros.wait_until(lambda: stream.publish(String(data="early")) or "early" in listener.heard)
    stream.publish(String(data="late"))
    stream.publish(String(data="later"))
    news.publish(String(data="carried"))
    state.publish(String(data="as it is"))
    time.sleep(STALL)
    assert ros.wait_until(lambda: listener.states == ["as it is"])
    assert ros.wait_until(lambda: listener.news[-1] == "carried")
    assert ros.wait_until(lambda: listener.backlog.guard.count >= 1)
    assert listener.backlog.guard.gap >= STALL
    assert ros.wait_until(lambda: stream.publish(String(data="new")) or "new" in listener.heard)
    assert "late" not in listener.heard
    assert "later" not in listener.heard
