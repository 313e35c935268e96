"""Impacts of the telemetry in the map frame, by poses of then: no node, and a clock that the test sets."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from rclpy.serialization import serialize_message
from telemetry_example import TELEMETRY

from collplan_core.parameters import Settings
from collplan_core.state import State
from collplan_ros.messages.cloud_reading import impact_from_cloud
from collplan_ros.messages.conversions import state_to_odometry
from omnipuck_driver.sensed_impacts import SensedImpacts

USED = Settings().with_values({"limits.pose_history": 0.5})
SPEED, YAW = 0.8, 0.5
AHEAD = np.array([np.cos(YAW), np.sin(YAW)])


class Bench:
    """Poses each 10 ms of a robot that goes along x, turned by YAW; what is published, by topic."""

    def __init__(self) -> None:
        self.published: dict[str, list] = {}
        self.local = 0.0
        clock = SimpleNamespace(now=lambda: SimpleNamespace(nanoseconds=round(self.local * 1e9)))
        self.sensed = SensedImpacts(self, self, USED, clock)
        for n in range(201):
            self.local = n / 100
            state = State(self.local, np.array([SPEED * self.local, 0.0]), np.array([SPEED, 0.0]), YAW)
            self._take_pose(serialize_message(state_to_odometry(state, USED.frames.map, USED.frames.base)))
        self.sensed.take(TELEMETRY)

    def create_publisher(self, message_type, topic, qos):
        return SimpleNamespace(publish=self.published.setdefault(topic, []).append)

    def listen(self, message_type, topic, callback, qos, kind, raw):
        self._take_pose = callback

    def told(self, age: float) -> None:
        self.sensed.take(replace(TELEMETRY, impacts=1, impact_age=round(1e3 * age), impact=(-0.5, 0.0)))


def test_an_impact_is_where_the_robot_was_then():
    for later, age in ((0.0, 0.0), (0.0, 0.495), (0.05, 0.2)):
        bench = Bench()
        bench.local += later
        bench.told(age)
        assert (bench.sensed.published, bench.sensed.missed) == (1, 0)
        contact = impact_from_cloud(bench.published["impact/contact"][0], USED.frames.map)
        then = 2.0 + later - age
        assert contact.time == pytest.approx(then)
        np.testing.assert_allclose(contact.point, [SPEED * then, 0.0] + USED.robot.radius * AHEAD, atol=1e-6)
        np.testing.assert_allclose(contact.normal, -AHEAD, atol=1e-6)
        change = bench.published["impact"][0]
        assert change.header.frame_id == USED.frames.map
        np.testing.assert_allclose([change.vector.x, change.vector.y], -0.5 * AHEAD, atol=1e-6)


def test_one_that_is_older_than_the_poses_kept_is_missed():
    bench = Bench()
    bench.told(0.6)
    assert (bench.sensed.published, bench.sensed.missed) == (0, 1)
    assert bench.published == {"impact/contact": [], "impact": []}
