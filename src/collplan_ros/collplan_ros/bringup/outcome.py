"""The outcome of a run: the end of the goal by the planner's report, else by the monitor."""

import numpy as np
from action_msgs.msg import GoalStatus

from collplan_core.evaluation import run_end
from collplan_core.evaluation.run_end import RunMonitor
from collplan_ros.messages.goal_status import NUMBERS
from collplan_ros.run.recorder import GoalReport
from collplan_ros.run.run_log import PoseRow

OUTCOMES = {NUMBERS[status]: outcome for status, outcome in run_end.OUTCOMES.items()}
"""Outcome of a run by the final status of its goal, one of GoalStatus.STATUS_*."""


def outcome_of(goal: GoalReport | None, pose: PoseRow, maneuver: str, monitor: RunMonitor) -> str | None:
    """Outcome of a run at its newest pose and maneuver, None while it goes on.

    The planner's report of the goal's end has priority over the monitor, however old the pose. A report is used
    only once the poses sent before it were taken: time counts from the first of those after the first plan, and the
    time of arrival is read from them.
    """
    monitor.commanded(maneuver)
    final = goal is not None and goal.status in OUTCOMES
    if goal is not None and goal.sent <= pose.sent:
        if final:
            return OUTCOMES[goal.status]
        if goal.status == GoalStatus.STATUS_EXECUTING:
            monitor.executing(pose.stamp)
    return None if final else monitor.outcome(pose.stamp, np.array([pose.x, pose.y]))
