"""The outcome of a run by the planner's word and the poses, however late and in whatever order they come."""

import numpy as np
from action_msgs.msg import GoalStatus
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.command import FREE_SPACE
from collplan_core.evaluation.run_end import ABORTED, CANCELED, REACHED, RunMonitor
from collplan_core.parameters import Trial
from collplan_ros.bringup.ending import outcome_of
from collplan_ros.run.recorder import GoalReport
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


def test_a_goal_known_to_have_ended_is_neither_timed_out_nor_stuck_before_the_poses_of_then():
    arrived = GoalReport(GoalStatus.STATUS_SUCCEEDED, SENT + 50.0)
    monitor = RunMonitor(LIMITS, STAMP)
    monitor.executing(STAMP)
    assert {outcome_of(arrived, pose(t, 0.0), FREE_SPACE, monitor) for t in (0.0, 10.0, 40.0, 49.99)} == {None}
    assert outcome_of(arrived, pose(50.0, 0.0), FREE_SPACE, monitor) == REACHED
