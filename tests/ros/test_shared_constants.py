"""Constants that all nodes of a graph share: what is compared, and what a node makes of it."""

import pytest
from rclpy.node import Node
from terminal import ERROR as ERROR_LINE
from terminal import Terminal

from collplan_core.parameters import Frames, Robot
from collplan_ros.node_kit.diagnostics import ERROR, OK, WARN, Health
from collplan_ros.node_kit.node_parameters import declare, read_settings
from collplan_ros.node_kit.shared_constants import SharedConstants, disagreement

RADIUS = {"robot.radius": "0.09"}


def test_disagreement_in_words():
    for others, words in (
        ({"/a": RADIUS, "/b": {}, "/c": {"frames.map": "'odom'"}}, ""),
        (
            {"/b": {"robot.radius": "0.2"}, "/c": {"robot.radius": "0.15"}, "/a": {"robot.radius": "0.15"}},
            "robot.radius: 0.09 here, 0.15 in /a, /c; robot.radius: 0.09 here, 0.2 in /b",
        ),
    ):
        assert disagreement(RADIUS, others) == words


@pytest.fixture
def ros(ros):
    ros.forget_others()
    return ros


class Sharing(Node):
    def __init__(self, name, **kwargs):
        super().__init__(name, **kwargs)
        declare(self, Robot, Frames)
        self.constants = SharedConstants(self, read_settings(self, Robot, Frames), Robot, Frames)
        self.constants.compare()


def make(ros, name, namespace="", **values):
    parameters = {f"robot.{key}": value for key, value in values.items()}
    return ros.make(lambda **kwargs: Sharing(name, namespace=namespace, **kwargs), parameters)


def judged(node, health):
    return health.with_inputs({}, [], node.constants.disagreement)


def test_nodes_that_disagree_name_the_key_until_one_ends(ros):
    terminal = Terminal(ros)
    here = make(ros, "here")
    well, unwell = Health(OK, "fine", {"count": 1}), Health(ERROR, "worse")
    assert judged(here, well) == well
    there = make(ros, "there", radius=0.15)
    assert ros.wait_until(lambda: here.constants.disagreement and there.constants.disagreement)
    reason = "robot.radius: 0.09 here, 0.15 in /there"
    assert here.constants.disagreement == reason
    assert judged(here, well) == Health(WARN, reason, {"count": 1})
    assert judged(here, unwell) == unwell
    assert terminal.has(here, reason)
    ros.spin(1.5)  # what is checked again is not said again
    assert [level for level, _ in terminal.lines(here)] == [ERROR_LINE]
    ros.remove(there)
    assert ros.wait_until(lambda: not here.constants.disagreement)
    assert terminal.has(here, "agree again")


def test_robots_in_other_namespaces_are_other_robots(ros):
    one, other = make(ros, "node", "/robot1"), make(ros, "node", "/robot2", radius=0.15)
    beside = make(ros, "beside", "/robot1", mass=2.0)
    assert ros.wait_until(lambda: one.constants.disagreement and beside.constants.disagreement)
    assert one.constants.disagreement == "robot.mass: 0.7 here, 2.0 in /robot1/beside"
    assert beside.constants.disagreement == "robot.mass: 2.0 here, 0.7 in /robot1/node"
    assert other.constants.disagreement == ""
