"""The whole graph as a robot of Nav2: a goal by the action NavigateToPose, the robot on /tf."""

import numpy as np
from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from straight_planner import STRAIGHT

from collplan_core.planners import PLANNERS
from collplan_core.worlds import save_world
from collplan_ros.messages.conversions import goal_to_message
from collplan_ros.messages.mocap_formats import FORMATS
from fake_robot import hall
from simulated_graph import Graph


def test_a_client_drives_the_robot_to_its_goal_and_sees_it_on_tf(ros, real_messages, tmp_path, monkeypatch):
    navigate, transforms = real_messages("nav2_msgs.action").NavigateToPose, real_messages("tf2_msgs.msg").TFMessage
    monkeypatch.setitem(PLANNERS, "custom", STRAIGHT)
    world = tmp_path / "hall.yaml"
    save_world(hall(), world)
    broadcast = ros.listen(transforms, "/tf", 100)
    graph = Graph(ros, str(world), transforms=True, planner__strategy="custom")
    client = ActionClient(ros.probe, navigate, "navigate_to_pose")
    assert ros.wait_until(client.server_is_ready)
    feedback = []
    goal = navigate.Goal(pose=goal_to_message(hall().goal, "map"))
    sent = client.send_goal_async(goal, lambda message: feedback.append(message.feedback))
    assert ros.wait_until(sent.done)
    assert sent.result().accepted
    end = sent.result().get_result_async()
    assert ros.wait_until(end.done, clock=lambda: graph.state.stamp)
    assert end.result().status == GoalStatus.STATUS_SUCCEEDED
    client.destroy()
    left = [each.distance_remaining for each in feedback]
    assert left[0] > 1.8
    assert left[-1] < 0.5
    assert feedback[-1].navigation_time.sec >= 1
    where = FORMATS["tf"].read(broadcast[-1], "base_link")
    assert np.hypot(*(np.array(where.position[:2]) - hall().goal)) < 0.25
    assert where.stamp == graph.state.stamp
