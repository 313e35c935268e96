"""What a run's log says does not depend on when its messages were taken."""

from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Point, PointStamped, Twist, Vector3
from hypothesis import given, settings
from hypothesis import strategies as st
from std_msgs.msg import String

from collplan_core.parameters import Settings
from collplan_core.sensing.impact_contact import ImpactContact
from collplan_core.state import State
from collplan_core.worlds import World
from collplan_ros.messages.conversions import impact_contact_to_message, impact_to_message, state_to_odometry
from collplan_ros.runs.impact_log import impacts_of
from collplan_ros.runs.recorder import Recorder
from collplan_ros.runs.run_log import RunLog
from collplan_ros.runs.summary import summarize
from collplan_ros.runs.trajectory_file import write_trajectory

STAMP, WALL_CLOCK = 50.0, 1.7e9
FIRST_MOVE, ARRIVAL = 0.5, 2.0
SENT_LATE = 0.003
"""A pose is handed on so long after it was measured [s]."""
WORLD = World("empty", (), np.zeros((0, 3)), (-1.0, -1.0, 5.0, 1.0), False, None, None)


class Ears:
    """Stands in for a node: keeps what would be called, by topic."""

    def __init__(self) -> None:
        self.take = {}

    def create_subscription(self, _kind, topic, take, _qos) -> None:
        self.take[topic] = take


def sent_messages(end: float = ARRIVAL) -> dict[str, list[tuple[float, object]]]:
    """When each message of a run up to `end` [s] was sent, and the message, by topic."""
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
    """The log of a run whose messages are taken in this order of their topics."""
    ears, topics = Ears(), sent_messages()
    recorder = Recorder(ears, Settings())
    recorder.begin()
    for topic in order:
        sent, message = topics[topic].pop(0)
        ears.take[topic](message, {"source_timestamp": round((WALL_CLOCK + sent) * 1e9)})
    assert not any(topics.values())
    return recorder.log


def in_time() -> list[str]:
    """The topics in the order of sending."""
    return [topic for _, topic in sorted((sent, topic) for topic, rows in sent_messages().items() for sent, _ in rows)]


def arrival(log: RunLog) -> float:
    return summarize(log, impacts_of(log, WORLD, Settings().mocap.velocity_window), "reached", np.zeros(2), Settings())[
        "arrival_time_s"
    ]


def trajectory(log: RunLog, folder: Path) -> str:
    write_trajectory(folder / "trajectory.csv", log)
    return (folder / "trajectory.csv").read_text()


def test_time_zero_is_when_the_first_command_to_move_was_sent():
    log = recorded(in_time())
    assert log.time_zero == pytest.approx(STAMP + FIRST_MOVE + 0.004, abs=1e-5)
    assert arrival(log) == pytest.approx(ARRIVAL - FIRST_MOVE - 0.004, abs=1e-5)
    assert [c.maneuver for c in log.commands if c.vx] == ["free_space"] * 30
    assert {c.maneuver for c in log.commands if not c.vx} == {"stopped"}


@pytest.mark.parametrize("last", ["mocap/odom", "cmd_vel", "maneuver"])
def test_a_backlog_of_one_topic_changes_nothing(tmp_path, last):
    prompt, late = recorded(in_time()), recorded(sorted(in_time(), key=lambda topic: topic == last))
    assert arrival(late) == arrival(prompt)
    assert late.commands == prompt.commands
    assert trajectory(late, tmp_path) == trajectory(prompt, tmp_path)


@given(st.randoms(use_true_random=False))
@settings(derandomize=True, deadline=None, max_examples=15)
def test_no_order_of_taking_changes_the_log(random):
    order = in_time()
    random.shuffle(order)
    assert recorded(order) == recorded(in_time())


TOLERANCE = Settings().planner.goal_tolerance
GOAL = np.array([ARRIVAL - FIRST_MOVE + TOLERANCE - 0.004, 0.0])
"""The pose at ARRIVAL is the first one within the tolerance of it."""
REPORTED = ARRIVAL + 0.034
"""When a planner that is slow to see it reports the arrival."""


def driven_on() -> dict[str, list[tuple[float, object]]]:
    """The messages of a run that goes on after its arrival, with its truth and the planner's report of the goal."""
    topics = sent_messages(ARRIVAL + 0.4)
    for sent, odometry in topics["mocap/odom"]:
        topics["ground_truth/odom"].append((sent - SENT_LATE, odometry))
    for k in (30, 190, 215):
        topics["ground_truth/impact"].append((0.01 * k, truth(k)[1]))
    for sent, status in ((0.4, GoalStatus.STATUS_EXECUTING), (REPORTED, GoalStatus.STATUS_SUCCEEDED)):
        topics["goal_status"].append((sent, GoalStatus(status=status)))
    return topics


def recorded_to_the_end(order: list[str], patience: int) -> RunLog:
    """The log of such a run, finished so many messages after the report and a pose sent later have been taken."""
    ears, topics = Ears(), driven_on()
    recorder = Recorder(ears, Settings())
    recorder.begin()
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("collplan_ros.runs.recorder.time.time", lambda: WALL_CLOCK)
        recorder.ask(GOAL)
    for topic in order:
        sent, message = topics[topic].pop(0)
        info = {"source_timestamp": round((WALL_CLOCK + sent) * 1e9)}
        ears.take[topic](message, *([] if topic.startswith("ground_truth") else [info]))
        if recorder.newest and recorder.newest.sent >= (recorder.log.reached_sent or np.inf):
            patience -= 1
            if patience == 0:
                recorder.finish()
    recorder.finish()
    assert recorder.is_complete
    return recorder.log


@given(st.randoms(use_true_random=False), st.integers(1, 300))
@settings(derandomize=True, deadline=None, max_examples=15)
def test_the_log_ends_with_the_pose_that_arrived_whatever_was_taken_when(random, patience):
    prompt = [topic for _, topic in sorted((sent, topic) for topic, rows in driven_on().items() for sent, _ in rows)]
    log = recorded_to_the_end(prompt, 1)
    assert log.poses[-1].stamp == log.truth[-1].stamp == pytest.approx(STAMP + ARRIVAL)
    assert log.arrival == log.poses[-1].stamp
    assert len(log.true_impacts) == 2
    order = list(prompt)
    random.shuffle(order)
    assert recorded_to_the_end(order, patience) == log
    by_topic = sorted(prompt, key=lambda topic: topic != "goal_status")
    assert recorded_to_the_end(by_topic, patience) == log


def test_where_poses_were_lost_the_planner_tells_the_arrival():
    log = recorded(in_time())
    log.reached_sent = WALL_CLOCK + ARRIVAL + SENT_LATE + 0.001
    assert log.arrival == log.poses[-1].stamp
    lost = 20
    log.poses[-lost:] = [log.poses[-1]._replace(stamp=STAMP + ARRIVAL + 3.0, sent=WALL_CLOCK + ARRIVAL + 3.0)]
    assert log.arrival == pytest.approx(STAMP + ARRIVAL + 0.001, abs=1e-5)


def test_a_report_of_an_earlier_goal_is_not_about_the_new_one(monkeypatch):
    ears = Ears()
    recorder = Recorder(ears, Settings())
    monkeypatch.setattr("collplan_ros.runs.recorder.time.time", lambda: WALL_CLOCK)
    recorder.ask(np.zeros(2))
    done = GoalStatus(status=GoalStatus.STATUS_SUCCEEDED)
    ears.take["goal_status"](done, {"source_timestamp": round((WALL_CLOCK - 0.1) * 1e9)})
    assert recorder.goal is recorder.log.reached_sent is None
    ears.take["goal_status"](done, {"source_timestamp": round((WALL_CLOCK + 0.1) * 1e9)})
    assert recorder.goal.status == GoalStatus.STATUS_SUCCEEDED
    assert recorder.log.reached_sent == recorder.goal.sent


def truth(k: int):
    """The true state 10 ms times k after the first pose, and an impact then."""
    stamp, frames = STAMP + 0.01 * k, Settings().frames
    state = State(stamp, np.array([0.01 * k, 0.0]), np.zeros(2), 0.0)
    impact = impact_to_message(stamp, np.array([-1.0, 0.0]), frames.map)
    return state_to_odometry(state, frames.map, frames.base), impact


def test_truth_that_comes_after_the_last_pose_is_recorded_up_to_that_pose():
    ears = Ears()
    recorder = Recorder(ears, Settings())
    recorder.begin()
    assert recorder.is_complete
    ears.take["ground_truth/odom"](truth(0)[0])
    for k in range(6):
        ears.take["mocap/odom"](truth(k)[0], {"source_timestamp": round((WALL_CLOCK + 0.01 * k) * 1e9)})
    recorder.finish()
    for k in range(1, 9):
        assert recorder.is_complete == (k > 5)
        odometry, impact = truth(k)
        ears.take["ground_truth/odom"](odometry)
        ears.take["ground_truth/impact"](impact)
    assert [row.stamp for row in recorder.log.truth] == pytest.approx(STAMP + 0.01 * np.arange(6))
    assert [impact.stamp for impact in recorder.log.true_impacts] == pytest.approx(STAMP + 0.01 * np.arange(1, 6))


def test_a_detected_impact_is_recorded_with_its_own_time_and_place_and_none_after_the_end():
    ears = Ears()
    recorder = Recorder(ears, Settings())
    recorder.begin()
    ears.take["mocap/odom"](truth(20)[0], {"source_timestamp": round(WALL_CLOCK * 1e9)})
    recorder.finish()
    for time in (STAMP + 0.1, STAMP + 0.3):
        place = ImpactContact(time, np.array([1.0, 2.0]), np.array([0.0, -1.0]))
        ears.take["impact/contact"](impact_contact_to_message(place, Settings().frames.map))
    ears.take["impact/contact"](impact_contact_to_message(place, "elsewhere"))
    ((stamp, x, y, *normal),) = recorder.log.detected_impacts
    assert (stamp, x, y) == pytest.approx((STAMP + 0.1, 1.0, 2.0))
    assert normal == pytest.approx([0.0, -1.0])
    assert recorder.log.n_impacts == 1


def test_a_robot_without_truth_is_waited_for_by_nobody():
    recorder = Recorder(Ears(), Settings())
    recorder.begin()
    recorder.finish()
    assert recorder.is_complete
