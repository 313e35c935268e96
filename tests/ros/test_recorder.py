"""What a run's log says does not depend on when its messages were taken."""

from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point, PointStamped, Twist, Vector3
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String

from collplan_core.clock_steps import SendTimes
from collplan_core.impact import POSES, SIMULATED, Impact
from collplan_core.parameters import Settings
from collplan_core.state import State
from collplan_core.worlds import World
from collplan_ros.messages.conversions import state_to_odometry
from collplan_ros.messages.planner_clouds import impact_to_cloud
from collplan_ros.messages.raw_reading import BYTES_TOPICS
from collplan_ros.run.record import record_of
from collplan_ros.run.recorded_run import take_mark
from collplan_ros.run.recorder import Recorder
from collplan_ros.run.result_files import summarize, write_trajectory
from collplan_ros.run.run_log import LogBuilder, RunLog

STAMP, WALL_CLOCK = 50.0, 1.7e9
FIRST_MOVE, ARRIVAL = 0.5, 2.0
WINDOW = Settings().mocap.velocity_window
SENT_LATE = 0.003
"""A pose is handed on so long after it was measured [s]."""
WORLD = World("empty", (), np.zeros((0, 3)), (-1.0, -1.0, 5.0, 1.0), False, None, None)


class Recording:
    """A recorder that listens to no graph: it is handed messages and when they were sent [s], and so is a log."""

    def __init__(self, namespace: str = "/") -> None:
        self.listened = defaultdict(list)
        self._builder = LogBuilder(Settings())
        # by the steady clock the recorder begins at 0
        times = SendTimes(lambda: WALL_CLOCK, lambda: 0.0)
        self.recorder = Recorder(self, Settings(), self._mark, times, namespace)
        self.recorder.begin(True)

    def _mark(self, name, values) -> None:
        take_mark(self._builder, name, values)

    def listen(self, topic, take, raw=False) -> None:
        self.listened[topic].append((take, raw))

    def take(self, topic: str, sent: float, message: object) -> None:
        data = serialize_message(message) if topic in BYTES_TOPICS else message
        for take, raw in self.listened[topic]:
            assert raw == (topic in BYTES_TOPICS)
            take(data, sent)
        if topic in self._builder.topics:
            self._builder.take(topic, data, sent)

    @property
    def log(self) -> RunLog:
        return self._builder.log


def sent_messages(end: float = ARRIVAL) -> dict[str, list[tuple[float, object]]]:
    frames = Settings().frames
    topics = defaultdict(list)
    for k in range(round(100 * end) + 1):
        t = 0.01 * k
        state = State(STAMP + t, np.array([max(t - FIRST_MOVE, 0.0), 0.0]), np.zeros(2), 0.0)
        topics["mocap/odom"].append((t + SENT_LATE, state_to_odometry(state, frames.map, frames.base)))
    for k in range(round(20 * end)):
        t = 0.05 * k + SENT_LATE + 0.004
        moving = t > FIRST_MOVE
        topics["cmd_vel"].append((t, Twist(linear=Vector3(x=1.0 + k if moving else 0.0))))
        if moving:
            topics["controller/reference"].append((t + 1e-4, PointStamped(point=Point(x=float(k)))))
    topics["maneuver"].append((FIRST_MOVE + SENT_LATE + 0.0042, String(data="free_space")))
    return topics


def recorded(order: list[str]) -> RunLog:
    recording, topics = Recording(), sent_messages()
    for topic in order:
        recording.take(topic, *topics[topic].pop(0))
    assert not any(topics.values())
    return recording.log


def in_time() -> list[str]:
    return [topic for _, topic in sorted((sent, topic) for topic, rows in sent_messages().items() for sent, _ in rows)]


def test_diagnostics_of_other_robots_are_theirs():
    for namespace, own in (("/", "/mocap_node"), ("/robot1", "/robot1/mocap_node")):
        recording = Recording(namespace=namespace)
        names = ("/mocap_node", "/robot1/mocap_node", "/robot2/mocap_node", "/robot1/arm/mocap_node")
        recording.take("/diagnostics", 0.1, DiagnosticArray(status=[DiagnosticStatus(name=name) for name in names]))
        assert recording.recorder.reported.keys() == recording.recorder.reported_at.keys() == {own}


def arrival(log: RunLog) -> float:
    return summarize(log, record_of(log, WINDOW), "reached", np.zeros(2), Settings())["arrival_time_s"]


def trajectory(log: RunLog, folder: Path) -> str:
    write_trajectory(folder / "trajectory.csv", log)
    return (folder / "trajectory.csv").read_text()


def test_time_zero_is_when_the_first_command_to_move_was_sent():
    log = recorded(in_time())
    assert log.time_zero == pytest.approx(STAMP + FIRST_MOVE + 0.004, abs=1e-5)
    assert arrival(log) == pytest.approx(ARRIVAL - FIRST_MOVE - 0.004, abs=1e-5)
    record = record_of(log, WINDOW)
    moving, maneuvers = record.commands[:, 1] != 0.0, np.array(record.commanded)
    assert maneuvers[moving].tolist() == ["free_space"] * 30
    assert set(maneuvers[~moving]) == {"stopped"}


TOLERANCE = Settings().planner.goal_tolerance
GOAL = np.array([ARRIVAL - FIRST_MOVE + TOLERANCE - 0.004, 0.0])
"""The pose at ARRIVAL is the first one within the tolerance of it."""
REPORTED = ARRIVAL + 0.034
"""When a planner that is slow to see it reports the arrival."""


def driven_on() -> dict[str, list[tuple[float, object]]]:
    topics = sent_messages(ARRIVAL + 0.4)
    for sent, odometry in topics["mocap/odom"]:
        topics["ground_truth/odom"].append((sent - SENT_LATE, odometry))
    for k in (30, 190, 215):
        topics["ground_truth/impact/contact"].append((0.01 * k, truth(k)[1]))
    for sent, status in ((0.4, GoalStatus.STATUS_EXECUTING), (REPORTED, GoalStatus.STATUS_SUCCEEDED)):
        topics["goal_status"].append((sent, GoalStatus(status=status)))
    return topics


def recorded_to_the_end(order: list[str], patience: int) -> RunLog:
    """The log of such a run, finished so many messages after the report and a pose sent later have been taken."""
    recording, topics = Recording(), driven_on()
    recorder = recording.recorder
    recorder.ask(GOAL)
    for topic in order:
        recording.take(topic, *topics[topic].pop(0))
        reached = recorder.goal is not None and recorder.goal.status == GoalStatus.STATUS_SUCCEEDED
        if reached and recorder.newest and recorder.newest.sent >= recorder.goal.sent:
            patience -= 1
            if patience == 0:
                recorder.finish()
    recorder.finish()
    assert recorder.is_complete
    return recording.log


def comparable(log: RunLog) -> RunLog:
    return replace(log, impacts=[(impact.time, impact.source, *impact.point) for impact in log.impacts])


@given(st.randoms(use_true_random=False), st.integers(1, 300))
@settings(max_examples=20)
def test_the_log_ends_with_the_pose_that_arrived_whatever_was_taken_when(random, patience):
    prompt = [topic for _, topic in sorted((sent, topic) for topic, rows in driven_on().items() for sent, _ in rows)]
    log = recorded_to_the_end(prompt, 1)
    assert log.poses[-1].stamp == log.truth[-1].stamp == pytest.approx(STAMP + ARRIVAL)
    assert log.arrival == log.poses[-1].stamp
    assert [impact.time for impact in log.impacts] == pytest.approx([STAMP + 0.3, STAMP + 1.9])
    order = list(prompt)
    random.shuffle(order)
    assert comparable(recorded_to_the_end(order, patience)) == comparable(log)
    by_topic = sorted(prompt, key=lambda topic: topic != "goal_status")
    assert comparable(recorded_to_the_end(by_topic, patience)) == comparable(log)


def test_a_report_of_an_earlier_goal_is_not_about_the_new_one():
    recording = Recording()
    recording.recorder.ask(np.zeros(2))
    done = GoalStatus(status=GoalStatus.STATUS_SUCCEEDED)
    recording.take("goal_status", -0.1, done)
    assert recording.recorder.goal is recording.log.reached_sent is None
    recording.take("goal_status", 0.1, done)
    assert recording.recorder.goal.status == GoalStatus.STATUS_SUCCEEDED
    assert recording.log.reached_sent == recording.recorder.goal.sent == pytest.approx(0.1, abs=1e-6)


def hit_at(time: float, source: str) -> Impact:
    back = np.array([-1.0, 0.0])
    return Impact(time, np.array([1.0, 2.0]), back, -0.5 * back, 0.5 * back, source)


def truth(k: int):
    """The true state 10 ms times k after the first pose, and an impact then."""
    stamp, frames = STAMP + 0.01 * k, Settings().frames
    state = State(stamp, np.array([0.01 * k, 0.0]), np.zeros(2), 0.0)
    impact = impact_to_cloud(hit_at(stamp, SIMULATED), frames.map)
    return state_to_odometry(state, frames.map, frames.base), impact


def test_a_detected_impact_is_recorded_with_its_own_time_and_place_and_none_after_the_end():
    recording = Recording()
    recording.take("mocap/odom", 0.0, truth(20)[0])
    recording.recorder.finish()
    for time in (STAMP + 0.1, STAMP + 0.3):
        hit = hit_at(time, POSES)
        recording.take("impact/contact", 0.0, impact_to_cloud(hit, Settings().frames.map))
    recording.take("impact/contact", 0.0, impact_to_cloud(hit, "elsewhere"))
    (found,) = recording.log.impacts
    assert found.time == pytest.approx(STAMP + 0.1)
    assert (*found.point, *found.normal, found.speed_into, found.source) == (1.0, 2.0, -1.0, 0.0, 0.5, POSES)
    assert recording.recorder.n_impacts == 1


ODD = {
    "planner/costs": DiagnosticArray(status=[DiagnosticStatus(values=[KeyValue(key="candidates", value="many")])]),
    "cmd_vel": Twist(linear=Vector3(x=float("nan"))),
    "maneuver": String(data="\udc80\n\0"),
    "mocap/odom": Odometry(),
    "impact/contact": PointCloud2(),
    "goal_status": GoalStatus(status=99),
    "/diagnostics": DiagnosticArray(status=[DiagnosticStatus(name="\udc80")]),
}


def test_odd_messages_neither_end_a_run_nor_spoil_its_record(tmp_path):
    recording, topics = Recording(), sent_messages()
    for number, topic in enumerate(in_time()):
        recording.take(topic, *topics[topic].pop(0))
        if number == 3:
            for name, odd in ODD.items():
                recording.take(name, topics["mocap/odom"][0][0] - 0.001, odd)
    assert arrival(recording.log) == pytest.approx(ARRIVAL - FIRST_MOVE - 0.004, abs=1e-5)
    assert len(trajectory(recording.log, tmp_path).splitlines()) > len(recording.log.poses)
