"""A goal as an action: NavigateToPose of nav2_msgs, where that is installed.

A goal of the action is one like those of goal_pose, with the identity that its client gave it: the newest of both kinds
counts, and cancel ends either. The planner decides; here its clients learn what becomes of their goals.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from geometry_msgs.msg import PoseStamped
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.duration import Duration
from rclpy.node import Node

from collplan_core.goal import ABORTED, CANCELED, SUCCEEDED, Goal
from collplan_core.loop.decisions import Cycle, Decision
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.loop.recovery import way_left
from collplan_core.parameters import Settings
from collplan_core.poses.pose_filter import PoseSample
from collplan_ros.messages.conversions import pose_to_message

ACTION = "navigate_to_pose"
REPLACED = "replaced by a newer goal"
FAILED = 9000
"""Error code of a goal that was not reached: UNKNOWN of nav2_msgs after Jazzy, whose own names none."""

TakeDecisions = Callable[[Sequence[Decision], PlannerLoop, Settings, float], None]
TakeGoal = Callable[[PoseStamped, bytes], None]


def serve_goals(
    node: Node, take_goal: TakeGoal, cancel: Callable[[], object], drops: Callable[[], bool]
) -> TakeDecisions:
    """Serves the action in `node` if nav2_msgs is installed; returns what the planner's decisions are given to.

    `take_goal` takes a goal's message and its identity, 16 bytes; `cancel` ends the planner's goal; `drops` says
    whether a goal that comes now has queued up while the node was frozen, and is rejected.
    """
    try:
        from nav2_msgs.action import NavigateToPose
    except ImportError:
        return lambda *_: None
    goals = ActionGoals(NavigateToPose, take_goal, cancel)
    ActionServer(
        node,
        NavigateToPose,
        ACTION,
        # each goal is executed at its end, with a callback of its own
        execute_callback=lambda handle: NavigateToPose.Result(),
        goal_callback=lambda _: GoalResponse.REJECT if drops() else GoalResponse.ACCEPT,
        handle_accepted_callback=goals.accept,
        cancel_callback=goals.cancel,
    )
    return goals.take


class ActionGoals:
    """The goal of the action that is active, if any.

    rclpy's EventsExecutor polls a coroutine that waits, at full load. So a goal is executed when it has ended: until
    then its status is "accepted".
    """

    def __init__(self, action: Any, take_goal: TakeGoal, cancel: Callable[[], object]) -> None:
        """Takes goals of the type `action`."""
        self._action = action
        self._take_goal, self._cancel = take_goal, cancel
        self._handle: ServerGoalHandle | None = None
        self._since: float | None = None

    def accept(self, handle: ServerGoalHandle) -> None:
        """Takes a goal, which replaces the one before."""
        self._end(ABORTED, REPLACED)
        self._handle, self._since = handle, None
        self._take_goal(handle.request.pose, _identity(handle))

    def cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        """Ends a goal at its client's request."""
        if handle is not self._handle:
            return CancelResponse.REJECT
        self._cancel()
        return CancelResponse.ACCEPT

    def take(self, decisions: Sequence[Decision], loop: PlannerLoop, settings: Settings, local: float) -> None:
        """Passes on what the planner's loop has decided at `local` [s, local clock]."""
        for decision in decisions:
            if isinstance(decision, Goal) and self._handle is not None:
                if decision.id != _identity(self._handle):
                    self._end(ABORTED, REPLACED)
                elif not decision.active:
                    self._end(decision.status, loop.trouble or f"goal {decision.status}")
                elif self._since is None:
                    self._since = local
            elif isinstance(decision, Cycle) and self._handle is not None and self._since is not None:
                self._handle.publish_feedback(self._feedback(decision, loop, settings, local - self._since))

    def _feedback(self, cycle: Cycle, loop: PlannerLoop, settings: Settings, driven: float) -> Any:
        feedback, state = self._action.Feedback(), loop.state
        assert state is not None, "there is no plan without a pose"
        feedback.current_pose = pose_to_message(PoseSample(state.stamp, state.position, state.yaw), settings.frames.map)
        way, time = way_left(cycle.plan, loop.goal.position, settings.robot.fastest)
        feedback.distance_remaining = way
        feedback.estimated_time_remaining = Duration(seconds=time).to_msg()
        feedback.navigation_time = Duration(seconds=driven).to_msg()
        feedback.number_of_recoveries = loop.recovery_tries
        return feedback

    def _end(self, status: str, reason: str) -> None:
        handle, self._handle = self._handle, None
        if handle is not None:
            handle.execute(partial(self._result, status, reason))

    def _result(self, status: str, reason: str, handle: ServerGoalHandle) -> Any:
        """The result of a goal that has ended; called by the executor, after its client was answered."""
        if status == SUCCEEDED:
            handle.succeed()
        elif status == CANCELED and handle.is_cancel_requested:
            handle.canceled()
        else:
            # who called the service cancel is not the client
            handle.abort()
        return self._action.Result(error_code=FAILED if status == ABORTED else 0, error_msg=reason)


def _identity(handle: ServerGoalHandle) -> bytes:
    return bytes(bytearray(handle.goal_id.uuid))
