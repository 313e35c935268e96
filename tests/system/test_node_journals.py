"""The journals of the nodes, replayed on inputs of a trial one by one. Those of a graph: test_graph_reaches_goals."""

from array import array

from called_nodes import ask
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist
from rclpy.parameter import Parameter
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Empty, String

from collplan_core.replay.comparison import Comparison, compare
from collplan_core.replay.journal import CONTROLLER, PLANNER
from collplan_core.replay.reading import Call, rows_of
from collplan_core.worlds import load_world
from collplan_ros.messages import qos
from collplan_ros.messages.conversions import goal_to_message
from collplan_ros.nodes.planner_node import PlannerNode
from collplan_ros.replay.recorded_journals import TOPICS, RecordedJournals
from test_one_loop import Nodes, recorded


class Recording:
    """Messages in the order in which they were heard."""

    def __init__(self) -> None:
        self.messages = []

    def hear(self, topic, message) -> None:
        self.messages.append((topic, message))

    def journals(self) -> RecordedJournals:
        return RecordedJournals(rows_of((message.data for topic, message in self.messages if topic in TOPICS), ""))

    def compared(self) -> list[Comparison]:
        """The comparisons of planner and controller."""
        journals = self.journals()
        return [next(compare(of, journals.events(of))) for of in (PLANNER, CONTROLLER)]

    def called(self, of) -> set[str]:
        """What the loop was asked."""
        return {event.name for event in self.journals().events(of) if isinstance(event, Call)}


class JournalledNodes(Nodes):
    """The two nodes called one by one, and what they publish."""

    def __init__(self, ros, strategy, monkeypatch) -> None:
        self.recording = Recording()
        super().__init__(ros, strategy, monkeypatch)
        # published before anything could be put in the way of it, and latched
        for name in TOPICS:
            heard = ros.listen(String, name, qos.JOURNAL)
            assert ros.wait_until(lambda heard=heard: heard)
            # while that was waited for the nodes have gone on
            self.recording.messages.insert(0, (name, heard[0]))

    def hear(self, name, message):
        self.recording.hear(name, message)
        super().hear(name, message)


def test_what_a_message_brings_is_in_the_journal(ros, monkeypatch):
    """Parameters, refused messages, a goal that is canceled, and one that is refused."""
    events = recorded("corridor", "harness", monkeypatch)
    nodes = JournalledNodes(ros, "harness", monkeypatch)
    for event in events[:250]:
        nodes.take(*event)
    assert nodes.planner.set_parameters([Parameter("planner.turn_penalty", value=7.0)])[0].successful
    assert nodes.controller.set_parameters([Parameter("controller.k_p", value=3.0)])[0].successful
    odd = goal_to_message(load_world("corridor").goal, "moon")
    scan = next(message for kind, message, _ in events if kind == "scan")
    empty = LaserScan(header=scan.header, ranges=array("f"))
    for event in [("scan", empty, nodes.local), ("goal_pose", odd, nodes.local), *events[250:330]]:
        nodes.take(*event)
    again = goal_to_message(load_world("corridor").goal, "map")
    for event in [("goal_pose", again, nodes.local), *events[330:450]]:
        nodes.take(*event)
    driven = Twist()
    driven.linear.y = 0.2
    # the first command of a sender is left out
    for event in [("robot/state", DiagnosticStatus(), nodes.local), *2 * [("hand/cmd_vel", driven, nodes.local)]]:
        nodes.take(*event)
    nodes.take("controller", None, nodes.local)
    assert nodes.commands[-1].linear.y > 0.0
    assert ask(nodes.planner, "cancel").success
    nodes.take("robot/resumed", Empty(), nodes.local)
    nodes.take("planner", None, nodes.local)
    nodes.take("controller", None, nodes.local)
    first, second = nodes.recording.compared()
    assert (first.end, second.end) == (None, None), f"{first.end}\n{second.end}"
    planner_called, controller_called = nodes.recording.called(PLANNER), nodes.recording.called(CONTROLLER)
    assert planner_called >= {"change_settings", "refuse", "refuse_goal", "take_goal", "cancel", "forget_scans"}
    assert "take_manual_command" in planner_called
    assert controller_called >= {"change_settings", "refuse", "resume", "take_plan"}
    assert controller_called >= {"take_robot_state", "take_manual_command"}


def test_a_recorder_that_comes_late_hears_the_journal_from_its_beginning(ros):
    ros.make(PlannerNode)
    ros.spin(0.5)
    heard = ros.listen(String, "planner/journal", qos.JOURNAL)
    assert ros.wait_until(lambda: len(heard) > 1)
    assert '"number":0,' in heard[0].data
