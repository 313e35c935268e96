"""What bringup makes of the planner's word and the poses, however late and in whatever order they come."""

import io
from typing import TextIO

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist, Vector3
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import serialize_message

from collplan_core.evaluation.run_end import ABORTED, CANCELED, REACHED, STUCK, TIMEOUT, RunMonitor
from collplan_core.parameters import Settings, Trial
from collplan_core.state import State
from collplan_ros.bringup import graph
from collplan_ros.bringup.failures import GraphError
from collplan_ros.bringup.main import EMERGENCY_STOP, Bringup
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.outcome import outcome_of
from collplan_ros.bringup.progress import Progress
from collplan_ros.messages.conversions import state_to_odometry
from collplan_ros.runs.record_file import RecordFile
from collplan_ros.runs.recorder import GoalReport, Recorder
from collplan_ros.runs.run_log import PoseRow
from collplan_ros.runs.send_times import SendTimes

STAMP, SENT = 100.0, 1.7e9
LIMITS = Trial(timeout=30.0, stuck_time=5.0, stuck_distance=0.05)
ACCEPTED, EXECUTING = GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING
FINAL = {
    GoalStatus.STATUS_SUCCEEDED: REACHED,
    GoalStatus.STATUS_ABORTED: ABORTED,
    GoalStatus.STATUS_CANCELED: CANCELED,
}


def pose(t: float, x: float) -> PoseRow:
    return PoseRow(STAMP + t, x, 0.0, 0.0, 0.0, 0.0, SENT + t)


def drive(wait: float, length: float, stand: float) -> list[PoseRow]:
    """Poses at 20 Hz of a robot that stands, drives at 1 m/s, and stands again."""
    times = 0.05 * np.arange(round(20 * (wait + length + stand)) + 1)
    return [pose(t, x) for t, x in zip(times, np.clip(times - wait, 0.0, length), strict=True)]


@given(st.floats(0.0, 20.0), st.floats(0.5, 20.0), st.sampled_from(sorted(FINAL)), st.randoms(use_true_random=False))
@settings(derandomize=True, deadline=None, max_examples=60)
def test_the_planners_word_is_the_outcome_however_far_the_poses_are_behind(wait, length, status, random):
    monitor, poses = RunMonitor(LIMITS, STAMP), drive(wait, length, 20.0)
    reports = [
        GoalReport(ACCEPTED, SENT),
        GoalReport(EXECUTING, SENT + wait),
        GoalReport(status, SENT + wait + length),
    ]
    # each report is taken when it was sent, or while the poses of an earlier time are
    known, taken = -1, []
    for row in poses:
        due = sum(report.sent <= row.sent for report in reports) - 1
        known = max(known, due, random.choice([known, known, known, due + 1 if due + 1 < len(reports) else due]))
        taken.append(outcome_of(reports[known], row, monitor))
        if taken[-1]:
            break
    assert set(taken[:-1]) <= {None}
    assert taken[-1] == FINAL[status]
    assert row.sent >= reports[-1].sent


def test_the_end_of_the_goal_counts_once_the_poses_sent_before_it_were_taken():
    arrived = GoalReport(GoalStatus.STATUS_SUCCEEDED, SENT + 7.0)
    monitor = RunMonitor(LIMITS, STAMP)
    monitor.executing(STAMP)
    assert outcome_of(arrived, pose(6.99, 0.0), monitor) is None
    assert outcome_of(arrived, pose(7.0, 0.0), monitor) == REACHED


def test_a_goal_known_to_have_ended_is_neither_timed_out_nor_stuck_before():
    arrived = GoalReport(GoalStatus.STATUS_SUCCEEDED, SENT + 50.0)
    monitor = RunMonitor(LIMITS, STAMP)
    monitor.executing(STAMP)
    assert {outcome_of(arrived, pose(t, 0.0), monitor) for t in (0.0, 10.0, 40.0)} == {None}
    assert outcome_of(arrived, pose(50.0, 0.0), monitor) == REACHED


def test_time_counts_from_the_first_plan():
    monitor = RunMonitor(LIMITS, STAMP)
    for t in np.arange(0.0, 20.0, 0.5):
        assert outcome_of(GoalReport(ACCEPTED, SENT), pose(t, 0.0), monitor) is None
    planned = GoalReport(EXECUTING, SENT + 20.2)
    outcomes = [outcome_of(planned, pose(t, 0.0), monitor) for t in np.arange(20.0, 26.0, 0.5)]
    assert outcomes == [None] * 11 + [STUCK]


class FedGraph(graph.Graph):
    """A graph that is not started: each step takes the next pose, sent `late` [s] ago; reports come with poses."""

    def __init__(self, bringup: Bringup, poses: list[tuple[State, float]], reports: dict[int, int]) -> None:
        super().__init__(bringup.preparation, bringup.folder, bringup.progress)
        self._take: dict[str, object] = {}
        self._poses, self._reports = iter(enumerate(poses)), reports
        self._record, self._now = RecordFile(bringup.folder.record), 0.0
        times = SendTimes(lambda: self._now, lambda: self._now)
        self.recorder = Recorder(self, bringup.preparation.settings, self._record, times)

    def listen(self, topic, take, raw=False) -> None:
        self._take[topic] = (lambda message, info: take(serialize_message(message), info)) if raw else take

    def last_message(self, node: str) -> str:
        return "as usual"

    frozen = ""

    def give_goal(self, goal) -> None:
        self.recorder.ask(goal)
        self.recorder.goal = GoalReport(ACCEPTED, self._now)
        self.step()

    def step(self) -> None:
        number, (state, late) = next(self._poses)
        sent = {"source_timestamp": round(1e9 * (state.stamp - STAMP))}
        self._now = state.stamp - STAMP + late
        if number in self._reports:
            self._take["goal_status"](GoalStatus(status=self._reports[number]), sent)
        frames = Settings().frames
        self._take["mocap/odom"](state_to_odometry(state, frames.map, frames.base), sent)


def fed(
    tmp_path, positions: list[float], lateness: list[float], reports: dict[int, int], said: TextIO | None = None
) -> Bringup:
    """A bringup that takes poses 0.1 s apart at these positions on the x axis [m], each so late [s]."""
    bringup = Bringup(Options(out=tmp_path, timeout=10.0), Progress(said))
    states = [State(STAMP + 0.1 * k, np.array([x, 0.0]), np.zeros(2), 0.0) for k, x in enumerate(positions)]
    bringup.graph = FedGraph(bringup, list(zip(states, lateness, strict=True)), reports)
    return bringup


def test_poses_on_time_tell_that_the_robot_is_stuck_or_takes_too_long(tmp_path):
    standing = fed(tmp_path, [0.0] * 200, [0.0] * 200, {1: EXECUTING})
    assert standing.drive() == STUCK
    assert standing.graph.pose.stamp == pytest.approx(STAMP + 5.1)
    assert standing.reason(STUCK) == "stuck: less than 0.05 m away within 5 s; planner_node: as usual"
    driving = fed(tmp_path, [0.1 * k for k in range(200)], [0.0] * 200, {1: EXECUTING})
    assert driving.drive() == TIMEOUT
    assert driving.graph.pose.stamp == pytest.approx(STAMP + 10.1, abs=1e-3)
    unplanned = fed(tmp_path, [0.0] * 200, [0.0] * 200, {})
    assert unplanned.drive() == STUCK
    assert unplanned.reason(STUCK).startswith("stuck: no plan within 10 s")


def test_what_robot_and_controller_say_comes_before_the_planners_word(tmp_path):
    sent = {"source_timestamp": 0}
    values = [KeyValue(key="activity", value="stopped")]
    standing = fed(tmp_path, [0.0] * 200, [0.0] * 200, {1: EXECUTING})
    said = DiagnosticStatus(message="stands still: planner heartbeat 0.24 s old", values=values)
    standing.graph._take["controller/state"](said, sent)
    assert standing.drive() == STUCK
    assert standing.reason(STUCK).endswith("within 5 s; controller_node: stands still: planner heartbeat 0.24 s old")
    held = fed(tmp_path, [0.0] * 200, [0.0] * 200, {1: EXECUTING})
    values = [KeyValue(key="state", value="held"), KeyValue(key="reason", value="no fresh command for 1.0 s")]
    held.graph._take["robot/state"](DiagnosticStatus(message="held, and what frees it", values=values), sent)
    assert held.drive() == STUCK
    assert held.reason(STUCK) == "stuck: the robot is held: no fresh command for 1.0 s"


def test_an_emergency_stop_ends_the_run_with_its_reason(tmp_path):
    bringup = fed(tmp_path, [0.1 * k for k in range(200)], [0.0] * 200, {1: EXECUTING})
    state = DiagnosticStatus(name="/driver_node", message="emergency stop by the button on the robot")
    step = bringup.graph.step

    def pressed() -> None:
        step()
        if bringup.graph.pose.x > 2.0:
            state.values = [KeyValue(key="state", value="stopped")]
            bringup.graph._take["robot/state"](state, {"source_timestamp": 0})

    bringup.graph.step = pressed
    assert bringup.drive() == EMERGENCY_STOP
    assert bringup.graph.pose.x < 2.5
    assert bringup.reason(EMERGENCY_STOP) == "emergency stop by the button on the robot"


def test_what_late_poses_show_is_not_the_outcome_of_a_run_that_goes_on(tmp_path):
    positions = [0.0] * 60 + [0.1 * k for k in range(40)]
    lateness = [0.0] * 3 + [6.0] * 57 + [0.0] * 40
    bringup = fed(tmp_path, positions, lateness, {1: EXECUTING, 95: GoalStatus.STATUS_SUCCEEDED})
    assert bringup.drive() == REACHED


@pytest.mark.parametrize(("late", "lines"), [(0.0, 1), (0.9, 1), (1.1, 0), (6.0, 0)])
def test_what_late_poses_show_is_not_told_as_the_state_of_the_robot(tmp_path, late, lines):
    said = io.StringIO()
    bringup = fed(
        tmp_path, [0.1 * k for k in range(30)], [late] * 30, {1: EXECUTING, 25: GoalStatus.STATUS_SUCCEEDED}, said
    )
    give_goal = bringup.graph.give_goal

    def commanded(goal) -> None:
        give_goal(goal)
        bringup.graph._take["cmd_vel"](Twist(linear=Vector3(x=0.5)), {"source_timestamp": 0})

    bringup.graph.give_goal = commanded
    assert bringup.drive() == REACHED
    assert said.getvalue().count("m to the goal") == lines


def test_a_machine_too_slow_for_the_graph_is_said_instead(tmp_path, monkeypatch):
    monkeypatch.setattr(graph, "CATCH_UP_PATIENCE", 0.0)
    bringup = fed(tmp_path, [0.0] * 300, [1.3] * 300, {1: EXECUTING})
    with pytest.raises(GraphError, match=r"^poses come 1.3 s late: this machine is too slow for the graph$"):
        bringup.drive()
