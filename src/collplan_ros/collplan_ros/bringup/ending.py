"""How a run ends: exit codes, the exceptions that break it off, and its outcome by the end of its goal."""

import signal

import numpy as np
from action_msgs.msg import GoalStatus

from collplan_core.evaluation import run_end
from collplan_core.evaluation.run_end import CANCELED, STUCK, TIMEOUT, RunMonitor
from collplan_ros.messages.states import NUMBERS
from collplan_ros.run.recorder import GoalReport
from collplan_ros.run.run_log import PoseRow
from collplan_ros.run.whole_file import RecordError

NOT_REACHED, NOT_STARTED, GRAPH_LOST, RECORD_LOST = 1, 2, 3, 4


class StartError(RuntimeError):
    """A request that cannot be fulfilled; nothing was started."""


class GraphError(RuntimeError):
    """The graph did not come up, or a part of it was lost."""

    outcome, exit_code = "graph_lost", GRAPH_LOST


class NodeDied(GraphError):
    """A node ended by itself; the message holds its name and how it ended."""

    outcome = "node_died"


class NodeRefused(NodeDied):
    """A node that could not be made of what it was given, as a parameter that does not fit; the message as before."""

    exit_code = NOT_STARTED


class DrivesOn(GraphError):
    """The robot moves, or its own node has held it, after it was told to stand at the end of a run."""

    outcome = "drives_on"


class Interrupted(RuntimeError):
    """A signal asked bringup to stop."""

    outcome = "interrupted"

    def __init__(self, number: int) -> None:
        """Keeps the exit code for the signal's `number`."""
        by = "Ctrl-C" if number == signal.SIGINT else signal.Signals(number).name
        super().__init__(f"stopped by {by}")
        self.exit_code = 128 + number


BROKEN_OFF = (GraphError, Interrupted, RecordError)  # exceptions that end a run before its outcome
EMERGENCY_STOP = "emergency_stop"  # outcome of a run in which the robot's emergency stop was latched
BY_A_PERSON = (CANCELED, EMERGENCY_STOP)  # outcomes after which the robot stands until a person gives a goal
MONITORED = (TIMEOUT, STUCK)  # outcomes that no node reports
OUTCOMES = {NUMBERS[status]: outcome for status, outcome in run_end.OUTCOMES.items()}
"""Outcome of a run by the final status of its goal, one of GoalStatus.STATUS_*."""


def outcome_of(goal: GoalReport | None, pose: PoseRow, maneuver: str, monitor: RunMonitor) -> str | None:
    """Outcome of a run at its newest pose and maneuver, None while it goes on.

    The planner's report of the goal's end has priority over the monitor, however old the pose. It is used only once the
    poses sent before it were taken: time counts from the first of those after the first plan, and the time of arrival
    is read from them.
    """
    monitor.commanded(maneuver)
    final = goal is not None and goal.status in OUTCOMES
    if goal is not None and goal.sent <= pose.sent:
        if final:
            return OUTCOMES[goal.status]
        if goal.status == GoalStatus.STATUS_EXECUTING:
            monitor.executing(pose.stamp)
    return None if final else monitor.outcome(pose.stamp, np.array([pose.x, pose.y]))
