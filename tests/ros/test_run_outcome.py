"""The outcome of a run by the planner's word and the poses, however late and in whatever order they come."""

from collections import defaultdict
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import serialize_message

from collplan_core.command import FREE_SPACE
from collplan_core.evaluation.run_end import ABORTED, CANCELED, REACHED, STUCK, TIMEOUT, RunMonitor
from collplan_core.parameters import Settings, Trial
from collplan_core.set_clocks import SendTimes
from collplan_core.state import State
from collplan_ros.bringup import graph
from collplan_ros.bringup.complaints import Complaints
from collplan_ros.bringup.failures import GraphError
from collplan_ros.bringup.main import Bringup
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.outcome import outcome_of
from collplan_ros.bringup.progress import Progress
from collplan_ros.messages.conversions import state_to_odometry
from collplan_ros.run.recorder import GoalReport, Recorder
from collplan_ros.run.run_log import PoseRow

STAMP, SENT = 100.0, 1.7e9
LIMITS = Trial(timeout=30.0, stuck_time=5.0, stuck_distance=0.05)
ACCEPTED, EXECUTING = GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING
FINAL = {GoalStatus.STATUS_SUCCEEDED: REACHED, GoalStatus.STATUS_ABORTED: ABORTED, GoalStatus.STATUS_CANCELED: CANCELED}


def pose(t: float, x: float) -> PoseRow:
    return PoseRow(STAMP + t, x, 0.0, 0.0, 0.0, 0.0, SENT + t)


def drive(wait: float, length: float, stand: float) -> list[PoseRow]:
    """Poses at 20 Hz of a robot that stands, drives at 1 m/s, and stands again."""
    times = 0.05 * np.arange(round(20 * (wait + length + stand)) + 1)
    return [pose(t, x) for t, x in zip(times, np.clip(times - wait, 0.0, length), strict=True)]


@given(st.floats(0.0, 20.0), st.floats(0.5, 20.0), st.sampled_from(sorted(FINAL)), st.randoms(use_true_random=False))
@settings(derandomize=True, deadline=None, max_examples=30)
def test_the_planners_word_is_the_outcome_however_far_the_poses_are_behind(wait, length, status, random):
    monitor, poses = RunMonitor(LIMITS, STAMP), drive(wait, length, 20.0)
    reports = [GoalReport(ACCEPTED, SENT), GoalReport(EXECUTING, SENT + wait), GoalReport(status, SENT + wait + length)]
    # each report is taken when it was sent, or while the poses of an earlier time are
    known, taken = -1, []
    for row in poses:
        due = sum(report.sent <= row.sent for report in reports) - 1
        known = max(known, due, random.choice([known, known, known, due + 1 if due + 1 < len(reports) else due]))
        taken.append(outcome_of(reports[known], row, FREE_SPACE, monitor))
        if taken[-1]:
            break
    assert set(taken[:-1]) <= {None}
    assert taken[-1] == FINAL[status]
    assert row.sent >= reports[-1].sent


def outcomes(reports: list[tuple[int, float]], rows: list[PoseRow]) -> list[str | None]:
    """At each pose, with the newest report that was sent before it."""
    monitor, given_reports = RunMonitor(LIMITS, STAMP), [GoalReport(status, SENT + sent) for status, sent in reports]
    newest = (max((r for r in given_reports if r.sent <= row.sent), key=lambda r: r.sent) for row in rows)
    return [outcome_of(report, row, FREE_SPACE, monitor) for report, row in zip(newest, rows, strict=True)]


def test_time_counts_from_the_first_plan_until_it_is_stuck_or_takes_too_long():
    reports = [(ACCEPTED, 0.0), (EXECUTING, 20.0)]
    for speed, outcome, lasts in ((0.0, STUCK, LIMITS.stuck_time), (0.1, TIMEOUT, LIMITS.timeout)):
        times = np.arange(0.0, 20.0 + lasts + 2.0, 0.5)
        found = outcomes(reports, [pose(t, speed * t) for t in times])
        ended = times[found.index(outcome)]
        assert 20.0 + lasts <= ended <= 20.5 + lasts
        assert set(found[: found.index(outcome)]) == {None}


def test_a_goal_known_to_have_ended_is_neither_timed_out_nor_stuck_before_the_poses_of_then():
    arrived = GoalReport(GoalStatus.STATUS_SUCCEEDED, SENT + 50.0)
    monitor = RunMonitor(LIMITS, STAMP)
    monitor.executing(STAMP)
    assert {outcome_of(arrived, pose(t, 0.0), FREE_SPACE, monitor) for t in (0.0, 10.0, 40.0, 49.99)} == {None}
    assert outcome_of(arrived, pose(50.0, 0.0), FREE_SPACE, monitor) == REACHED


class FedGraph(graph.Graph):
    """A graph that is not started: each step takes the next pose, sent `late` [s] ago; reports come with poses."""

    def __init__(self, bringup: Bringup, poses: list[tuple[State, float]], reports: dict[int, int]) -> None:
        super().__init__(bringup.preparation, bringup.folder, bringup.progress)
        self.taken_by: dict[str, list[Callable]] = defaultdict(list)
        self._fed, self._reports, self._time = iter(enumerate(poses)), reports, 0.0
        times = SendTimes(lambda: self._time, lambda: self._time)
        self.recorder = Recorder(self, bringup.preparation.settings, times=times)
        self.complaints = Complaints(bringup.preparation, self.recorder, SimpleNamespace(resolve_topic_name=str))
        self.listener = SimpleNamespace(silence=0.0)
        said = DiagnosticStatus(name="/planner_node", message="as usual")
        self._take("/diagnostics", DiagnosticArray(status=[said]), 0.0)

    def listen(self, topic, take, raw=False) -> None:
        self.taken_by[topic].append((lambda message, sent: take(serialize_message(message), sent)) if raw else take)

    def _take(self, topic, message, sent) -> None:
        for take in self.taken_by[topic]:
            take(message, sent)

    def give_goal(self, goal) -> None:
        self.recorder.ask(goal)
        self.recorder.goal = GoalReport(ACCEPTED, self._time)
        self.step()

    def step(self) -> None:
        number, (state, late) = next(self._fed)
        sent = state.stamp - STAMP
        self._time = state.stamp - STAMP + late
        if number in self._reports:
            self._take("goal_status", GoalStatus(status=self._reports[number]), sent)
        frames = Settings().frames
        self._take("mocap/odom", state_to_odometry(state, frames.map, frames.base), sent)

    def hears(self, topic: str, message: str, **values: str) -> None:
        pairs = [KeyValue(key=key, value=value) for key, value in values.items()]
        self._take(topic, DiagnosticStatus(message=message, values=pairs), 0.0)


def fed(tmp_path, positions: list[float], lateness: list[float], reports: dict[int, int]) -> Bringup:
    """A bringup that takes poses 0.1 s apart at these positions on the x axis [m], each so late [s]."""
    bringup = Bringup(Options(out=tmp_path, timeout=10.0), Progress(None))
    states = [State(STAMP + 0.1 * k, np.array([x, 0.0]), np.zeros(2), 0.0) for k, x in enumerate(positions)]
    bringup.graph = FedGraph(bringup, list(zip(states, lateness, strict=True)), reports)
    return bringup


def test_a_run_that_is_stuck_says_why_by_the_robot_then_the_controller_then_the_planner(tmp_path):
    stopped = "controller/state", "planner heartbeat 0.24 s old", {"activity": "stopped"}
    held = "robot/state", "and what frees it", {"state": "held", "reason": "no fresh command"}
    for heard, words in (([], "as usual"), ([stopped], "heartbeat"), ([stopped, held], "robot is held: no fresh")):
        standing = fed(tmp_path, [0.0] * 200, [0.0] * 200, {1: EXECUTING})
        for topic, message, values in heard:
            standing.graph.hears(topic, message, **values)
        assert standing.drive() == STUCK
        assert words in standing.reason(STUCK)
    unplanned = fed(tmp_path, [0.0] * 200, [0.0] * 200, {})
    assert unplanned.drive() == STUCK
    assert "no plan" in unplanned.reason(STUCK)


def test_a_machine_too_slow_for_the_graph_is_said_instead(tmp_path, monkeypatch):
    monkeypatch.setattr(graph, "CATCH_UP_PATIENCE", 0.0)
    bringup = fed(tmp_path, [0.0] * 300, [1.3] * 300, {1: EXECUTING})
    with pytest.raises(GraphError, match=r"1.3 s late.*too slow"):
        bringup.drive()
