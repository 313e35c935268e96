"""The picture of the node graph shows the running one, and refuses what it has no place for."""

import matplotlib as mpl
import pytest

import node_graph
from drawing import STYLE
from running_graph import NODES, Topics, topics_by_node


@pytest.fixture(scope="module")
def graph():
    return topics_by_node()


def test_every_topic_that_a_node_listens_to_is_drawn_from_end_to_end(graph, tmp_path):
    path = tmp_path / "node_graph.svg"
    with mpl.rc_context(STYLE):
        arrows = node_graph.draw(path, graph=graph)
    pairs = {(arrow.begin, arrow.end) for arrow in arrows}
    assert len(graph) == len(NODES)
    for node, topics in graph.items():
        for name in topics.subscribed:
            assert (node_graph.place_of(name), node_graph.box_of(node)) in pairs
    assert ("planner_node", "plan") in pairs
    assert ("plan", "controller_node") in pairs
    drawn = path.read_text(encoding="utf-8")
    for node, topics in graph.items():
        for text in (node, *topics.published, *topics.subscribed):
            assert f">{text}</text>" in drawn


def test_what_only_the_driver_does_is_told_apart(graph):
    sometimes = {(arrow.begin, arrow.end) for arrow in node_graph.arrows(graph) if not arrow.always}
    assert sometimes == {("mocap/odom", node_graph.ROBOT), (node_graph.ROBOT, "impact")}


def test_what_goes_with_a_plan_is_drawn_in_its_place_once_a_node_listens_to_it(tmp_path):
    told = {"plan": "Path", "planner/valid_until": "TimeReference"}
    graph = {
        "planner_node": Topics({**told, "planner/foreseen_impacts": "MultiDOFJointTrajectory"}, {}),
        "controller_node": Topics({}, told),
    }
    path = tmp_path / "node_graph.svg"
    with mpl.rc_context(STYLE):
        arrows = node_graph.draw(path, graph=graph)
    assert {(arrow.begin, arrow.end) for arrow in arrows} == {("planner_node", "plan"), ("plan", "controller_node")}
    drawn = path.read_text(encoding="utf-8")
    assert all(drawn.count(f">{topic}</text>") == 1 for topic in (*told, "planner/foreseen_impacts"))


def test_a_topic_without_a_place_is_refused():
    with pytest.raises(node_graph.NoPosition, match="topic tactile: no position"):
        node_graph.arrows({"planner_node": Topics({}, {"tactile": "Float64"})})


def test_a_node_without_a_place_is_refused():
    with pytest.raises(node_graph.NoPosition, match="node camera_node: no position"):
        node_graph.arrows({"camera_node": Topics({"scan": "LaserScan"}, {"cmd_vel": "Twist"})})
