"""The journals of the nodes, replayed on inputs of a trial one by one. Those of a graph: test_graph_reaches_goals."""

from array import array

from called_nodes import ask, give, tick
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Empty, String

from collplan_core.ages import StallGuard
from collplan_core.loop import closed_loop
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.parameters import Settings
from collplan_core.planners import map_period_of
from collplan_core.replay.comparison import Comparison, compare
from collplan_core.replay.journal import CONTROLLER, PLANNER
from collplan_core.replay.reading import Call, rows_of
from collplan_core.worlds import load_world
from collplan_ros.messages import conversions, qos
from collplan_ros.node_kit import graph_node
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.planner_node import PlannerNode
from collplan_ros.replay.recorded_journals import TOPICS, RecordedJournals
from omnipuck_sim import trial

MAP, BASE = "map", "base_link"


def recorded(world, strategy, monkeypatch) -> list[tuple]:
    """What a trial's planner and controller are given: (kind, message or None, local time), in order.

    As messages, because those round stamps to nanoseconds and ranges to single precision.
    """
    events = []

    class RecordedPlanner(PlannerLoop):
        def take_pose(self, state, local):
            events.append(("mocap/odom", conversions.state_to_odometry(state, MAP, BASE), local))
            return super().take_pose(state, local)

        def take_scan(self, scan, local):
            events.append(("scan", conversions.scan_to_message(scan, BASE), local))
            super().take_scan(scan, local)

        def take_impact(self, stamp, change, local):
            events.append(("impact", conversions.impact_to_message(stamp, change, MAP), local))
            return super().take_impact(stamp, change, local)

        def take_goal(self, identity, position, local):
            events.append(("goal_pose", conversions.goal_to_message(position, MAP), local))
            return super().take_goal(identity, position, local)

        def cycle(self, local):
            events.append(("planner", None, local))
            return super().cycle(local)

    class RecordedController(ControllerLoop):
        def tick(self, local):
            events.append(("controller", None, local))
            return super().tick(local)

    with monkeypatch.context() as patched:
        patched.setattr(closed_loop, "PlannerLoop", RecordedPlanner)
        patched.setattr(closed_loop, "ControllerLoop", RecordedController)
        trial.run_trial(load_world(world), settings_of(strategy), 1)
    return events


def settings_of(strategy: str) -> Settings:
    return Settings().with_values({"planner.strategy": strategy, "trial.timeout": 6.0})


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


class JournalledNodes:
    """The two nodes, with the time of a trial, their callbacks called one by one, what they publish handed on."""

    def __init__(self, ros, strategy, monkeypatch):
        self.recording = Recording()
        self.local, self.settings = 0.0, settings_of(strategy)
        monkeypatch.setattr(graph_node, "seconds", lambda clock: self.local)
        # nothing runs here between two callbacks, however long one takes
        monkeypatch.setattr(StallGuard, "tick", lambda self, *now: False)
        overrides = {"planner.strategy": strategy}
        self.planner, self.controller = (
            ros.make(PlannerNode, overrides),
            ros.make(ControllerNode, overrides),
        )
        # as in a trial the controller has a pose or a scan before the planner plans with it
        self.nodes = self.controller, self.planner
        self.commands = []
        for node in self.nodes:
            for publisher in node.publishers:
                name = publisher.topic_name.removeprefix("/")
                publisher.publish = lambda message, name=name, kind=publisher.msg_type: self.hear(
                    name, deserialize_message(message, kind) if isinstance(message, bytes) else message
                )

        # published before anything could be put in the way of it, and latched
        for name in TOPICS:
            heard = ros.listen(String, name, qos.JOURNAL)
            assert ros.wait_until(lambda heard=heard: heard)
            # while that was waited for the nodes have gone on
            self.recording.messages.insert(0, (name, heard[0]))

    def hear(self, name, message):
        self.recording.hear(name, message)
        if name == "cmd_vel":
            self.commands.append(message)
        if name in ("plan", "planner/trajectory", "goal_status", "cmd_vel"):
            self.give(name, message)

    def take(self, kind, message, local):
        self.local = local
        if kind == "planner":
            tick(self.planner, map_period_of(self.settings.planner))
        elif kind == "controller":
            tick(self.controller, 1.0 / self.settings.controller.rate)
        else:
            self.give(kind, message)

    def give(self, name, message):
        for node in self.nodes:
            give(node, name, message)


def test_what_a_message_brings_is_in_the_journal(ros, monkeypatch):
    """Parameters, refused messages, a goal that is canceled, and one that is refused."""
    events = recorded("corridor", "harness", monkeypatch)
    nodes = JournalledNodes(ros, "harness", monkeypatch)
    for event in events[:250]:
        nodes.take(*event)
    assert nodes.planner.set_parameters([Parameter("planner.turn_penalty", value=7.0)])[0].successful
    assert nodes.controller.set_parameters([Parameter("controller.k_p", value=3.0)])[0].successful
    odd = conversions.goal_to_message(load_world("corridor").goal, "moon")
    scan = next(message for kind, message, _ in events if kind == "scan")
    empty = LaserScan(header=scan.header, ranges=array("f"))
    for event in [("scan", empty, nodes.local), ("goal_pose", odd, nodes.local), *events[250:330]]:
        nodes.take(*event)
    again = conversions.goal_to_message(load_world("corridor").goal, "map")
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
