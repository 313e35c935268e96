"""The callbacks of the action NavigateToPose; no server runs, as nav2_msgs is not among the pip packages."""

import sys
import uuid
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from rclpy.action import CancelResponse, GoalResponse
from std_srvs.srv import Trigger

from collplan_core.parameters import Settings
from collplan_ros.messages.conversions import goal_to_message
from collplan_ros.messages.qos import EVENT
from collplan_ros.nodes import goal_action
from collplan_ros.nodes.planner_node import PlannerNode
from fake_robot import FakeRobot, hall


class Handle:
    """A goal handle: what its client would receive."""

    def __init__(self, x: float, frame: str = "map") -> None:
        self.goal_id = SimpleNamespace(uuid=np.frombuffer(uuid.uuid4().bytes, dtype=np.uint8))
        self.request = SimpleNamespace(pose=goal_to_message(np.array([x, 0.0]), frame))
        self.is_cancel_requested = False
        self.feedback, self.executed, self.ended = [], [], []
        self.publish_feedback, self.execute = self.feedback.append, self.executed.append

    def succeed(self):
        self.ended.append("succeeded")

    def canceled(self):
        self.ended.append("canceled")

    def abort(self):
        self.ended.append("aborted")

    def outcome(self):
        """State and result, as the executor makes them."""
        (callback,) = self.executed
        result = callback(self)
        (state,) = self.ended
        return state, result.error_code, result.error_msg


class ActionBench:
    """planner_node with the callbacks that it gives to the server, and a robot for it to plan for."""

    def __init__(self, ros, monkeypatch):
        module = ModuleType("nav2_msgs.action")
        module.NavigateToPose = SimpleNamespace(Feedback=SimpleNamespace, Result=SimpleNamespace)
        monkeypatch.setitem(sys.modules, "nav2_msgs", ModuleType("nav2_msgs"))
        monkeypatch.setitem(sys.modules, "nav2_msgs.action", module)
        made = []
        monkeypatch.setattr(goal_action, "ActionServer", lambda *given, **callbacks: made.append((given, callbacks)))
        self.ros, self.robot = ros, FakeRobot(ros, hall())
        self.node = ros.make(PlannerNode, {"planner.map_period": 0.05})
        (((_, _, self.name), self.callbacks),) = made
        assert ros.wait_until(self.robot.is_heard)

    def accepted(self, *goal) -> Handle:
        assert self.callbacks["goal_callback"](None) == GoalResponse.ACCEPT
        handle = Handle(*goal)
        self.callbacks["handle_accepted_callback"](handle)
        return handle

    def cancel(self, handle) -> CancelResponse:
        answer = self.callbacks["cancel_callback"](handle)
        handle.is_cancel_requested = answer == CancelResponse.ACCEPT
        return answer


@pytest.fixture
def bench(ros, monkeypatch):
    return ActionBench(ros, monkeypatch)


def test_a_client_learns_how_far_the_robot_is_and_that_it_arrived(ros, bench):
    assert bench.name == "navigate_to_pose"
    handle = bench.accepted(2.0)
    assert ros.wait_until(lambda: len(handle.feedback) > 1)
    before, feedback = handle.feedback[:2]
    assert 1.9 < feedback.distance_remaining < 2.5
    assert feedback.estimated_time_remaining.sec >= 2.0 // Settings().robot.max_speed
    assert before.navigation_time.nanosec < feedback.navigation_time.nanosec
    assert (feedback.current_pose.header.frame_id, feedback.number_of_recoveries) == ("map", 0)
    assert not handle.executed
    bench.robot.position = np.array([2.0, 0.09])
    assert ros.wait_until(lambda: handle.executed)
    assert handle.outcome() == ("succeeded", 0, "goal succeeded")


def test_a_goal_is_replaced_canceled_or_refused_with_the_reason(ros, bench):
    first, second = bench.accepted(2.0), bench.accepted(1.5)
    assert first.outcome() == ("aborted", goal_action.FAILED, goal_action.REPLACED)
    assert bench.cancel(first) == CancelResponse.REJECT
    ros.publisher(PoseStamped, "goal_pose", EVENT).publish(goal_to_message(np.array([1.0, 0.0]), "map"))
    assert ros.wait_until(lambda: second.executed)
    assert second.outcome()[2] == goal_action.REPLACED
    canceled = bench.accepted(2.0)
    assert bench.cancel(canceled) == CancelResponse.ACCEPT
    assert canceled.outcome() == ("canceled", 0, "goal canceled")
    ended = bench.accepted(2.0)
    assert ros.call(Trigger, "cancel").success
    assert ended.outcome() == ("aborted", 0, "goal canceled")
    state, code, reason = bench.accepted(2.0, "odom").outcome()
    assert (state, code) == ("aborted", goal_action.FAILED)
    assert "goal refused: " in reason
    assert "'odom'" in reason
