"""The action NavigateToPose as its clients see it, over DDS."""

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from rclpy.action import ActionClient
from std_srvs.srv import Trigger

from collplan_core.parameters import Settings
from collplan_ros.messages.conversions import goal_to_message
from collplan_ros.messages.qos import EVENT
from collplan_ros.node_kit.backlog import Backlog
from collplan_ros.nodes.goal_action import FAILED, REPLACED
from collplan_ros.nodes.planner_node import PlannerNode
from fake_robot import FakeRobot, hall

SUCCEEDED, CANCELED, ABORTED = GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED, GoalStatus.STATUS_ABORTED


class SentGoal:
    def __init__(self, bench, x: float, frame: str) -> None:
        self._wait_for = bench.wait_for
        self.feedback: list = []
        goal = bench.action.Goal(pose=goal_to_message(np.array([x, 0.0]), frame))
        take = self.feedback.append
        self._handle = self._wait_for(bench.client.send_goal_async(goal, lambda message: take(message.feedback)))
        self.accepted = self._handle.accepted
        self._end = self._handle.get_result_async() if self.accepted else None

    @property
    def has_ended(self) -> bool:
        return self._end.done()

    def cancel(self) -> bool:
        return bool(self._wait_for(self._handle.cancel_goal_async()).goals_canceling)

    def outcome(self) -> tuple[int, int, str]:
        end = self._wait_for(self._end)
        return end.status, end.result.error_code, end.result.error_msg


class ActionBench:
    def __init__(self, ros, action) -> None:
        self.ros, self.action, self.robot = ros, action, FakeRobot(ros, hall())
        self.node = ros.make(PlannerNode, {"planner.map_period": 0.05})
        self.client = ActionClient(ros.probe, action, "navigate_to_pose")
        assert ros.wait_until(lambda: self.robot.is_heard() and self.client.server_is_ready())

    def wait_for(self, future):
        assert self.ros.wait_until(future.done)
        return future.result()

    def sent(self, x: float, frame: str = "map") -> SentGoal:
        return SentGoal(self, x, frame)

    def driving(self, x: float = 2.0) -> SentGoal:
        goal = self.sent(x)
        assert goal.accepted
        assert self.ros.wait_until(lambda: goal.feedback)
        return goal


@pytest.fixture
def bench(ros, real_messages):
    bench = ActionBench(ros, real_messages("nav2_msgs.action").NavigateToPose)
    yield bench
    # it keeps its node, which is then listed to tests that follow
    bench.client.destroy()


def test_a_client_learns_how_far_the_robot_is_and_that_it_arrived(ros, bench):
    goal = bench.driving()
    assert ros.wait_until(lambda: len(goal.feedback) > 1)
    before, feedback = goal.feedback[:2]
    assert 1.9 < feedback.distance_remaining < 2.5
    assert feedback.estimated_time_remaining.sec >= 2.0 // Settings().robot.max_speed
    assert before.navigation_time.nanosec < feedback.navigation_time.nanosec
    assert (feedback.current_pose.header.frame_id, feedback.number_of_recoveries) == ("map", 0)
    assert not goal.has_ended
    bench.robot.position = np.array([2.0, 0.09])
    assert goal.outcome() == (SUCCEEDED, bench.action.Result.NONE, "goal succeeded")


def test_a_goal_is_canceled_replaced_by_either_kind_or_refused(ros, bench):
    goal = bench.driving()
    assert goal.cancel()
    assert goal.outcome() == (CANCELED, 0, "goal canceled")
    assert not goal.cancel()
    first, second = bench.driving(), bench.driving(1.5)
    assert first.outcome() == (ABORTED, FAILED, REPLACED)
    assert not first.cancel()
    assert not second.has_ended
    ros.publisher(PoseStamped, "goal_pose", EVENT).publish(goal_to_message(np.array([1.0, 0.0]), "map"))
    assert second.outcome() == (ABORTED, FAILED, REPLACED)
    goal = bench.driving()
    assert ros.call(Trigger, "cancel").success
    assert goal.outcome() == (ABORTED, 0, "goal canceled")
    status, code, reason = bench.sent(2.0, "odom").outcome()
    assert (status, code) == (ABORTED, FAILED)
    assert "goal refused: " in reason
    assert "'odom'" in reason


def test_a_goal_that_queued_up_while_the_node_was_frozen_is_rejected(ros, real_messages, monkeypatch):
    monkeypatch.setattr(Backlog, "holds", lambda _: True)
    assert not ActionBench(ros, real_messages("nav2_msgs.action").NavigateToPose).sent(2.0).accepted
