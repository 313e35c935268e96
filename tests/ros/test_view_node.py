"""view_node in this process: what a page gets of a graph, and what it can do to it."""

import json
import time
import urllib.request
from contextlib import ExitStack

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Path
from rclpy.parameter import Parameter
from sensor_msgs.msg import LaserScan, PointCloud2
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray
from websockets.sync.client import connect

from collplan_core.impact import Impact
from collplan_core.parameters import Planning, Robot, Simulation
from collplan_core.plan import Candidates, Contacts, timed_path
from collplan_ros.messages.conversions import goal_to_message, header
from collplan_ros.messages.mover_markers import movers_to_markers
from collplan_ros.messages.planner_clouds import compared_to_message, impact_to_cloud, plan_to_message, seen_to_message
from collplan_ros.messages.qos import DIAGNOSTICS_PUBLISHED, EVENT, LATCHED, NEWEST, SENSOR_DATA
from collplan_ros.messages.raw_reading import plan_to_path
from collplan_ros.messages.states import status_message
from collplan_ros.node_kit.diagnostics import OK, Health
from collplan_ros.node_kit.graph_node import GraphNode
from collplan_ros.nodes import view_node
from collplan_ros.nodes.view_node import ViewNode
from fake_robot import FakeRobot, hall
from node_health import NodeHealth


class Other(GraphNode):
    def __init__(self, name, *groups, **kwargs):
        super().__init__(name, groups, **kwargs)
        self._begin()

    def _health(self):
        return Health(OK, "fine", {"plans": 3})


class Bench:
    """A view_node, a page that is open, and all that it was sent so far, merged."""

    def __init__(self, ros, stack, namespace=""):
        self.ros = ros
        self.node = ros.make(ViewNode, {"view.port": 0}, namespace=namespace)
        self.answers = {}
        with urllib.request.urlopen(self.node.address) as page:
            self.token = page.read().decode().partition('name="token" content="')[2].partition('"')[0]
        self.open(stack)

    def open(self, stack):
        """Opens a page, which gets all there is anew."""
        self.parts = {}
        host = self.node.address.removeprefix("http://")
        self.page = stack.enter_context(connect(f"ws://{host}/frames", origin=self.node.address, proxy=None))

    def read(self):
        while True:
            try:
                message = json.loads(self.page.recv(timeout=0.001))
            except TimeoutError:
                return
            if "answer" in message:
                self.answers[message["answer"]] = message
            else:
                self.parts.update(message)

    def shows(self, condition, timeout=10.0):
        def reached():
            self.read()
            return condition(self.parts)

        return self.ros.wait_until(reached, timeout)

    def ask(self, **command):
        number = len(self.answers) + 1
        self.page.send(json.dumps({"token": self.token, "number": number, **command}))
        assert self.shows(lambda _: number in self.answers), f"no answer to {command}"
        return self.answers[number]["done"], self.answers[number]["text"]

    def latched(self, message_type, topic, message):
        self.ros.publisher(message_type, topic, LATCHED).publish(message)


@pytest.fixture
def stack():
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def bench(ros, stack):
    return Bench(ros, stack)


def state_message(name, reason="", **values):
    return status_message(name, OK, reason, {"reason": reason, **values})


# ---- what a page gets


def test_each_topic_is_on_the_page(ros, bench):
    contacts = Contacts(np.array([12.5]), np.array([[0.3, 0.4]]), np.array([[-0.5, 0.25]]), np.array([[-1.0, 0.0]]))
    way = np.array([[0.0, 0.2], [0.1, 0.2], [0.2, 0.2]])
    plan = timed_path(12.0, 12.0 + np.arange(3.0), way, 0.0 * way, contacts=contacts)
    ros.publisher(PointCloud2, "planner/trajectory", EVENT).publish(plan_to_message(plan, "map"))
    ros.spin(0.3)
    ros.publisher(Path, "plan", NEWEST).publish(plan_to_path(plan, "map"))
    nothing = np.zeros((0, 2))
    rollout = Candidates(nothing, nothing, np.zeros(0), (np.eye(2), 2 * np.eye(2)), (3.5, 1.25))
    bench.latched(PointCloud2, "planner/compared", compared_to_message(rollout, 12.0, "map"))
    bench.latched(PointCloud2, "planner/seen", seen_to_message({"free_space": np.eye(2)}, 12.0, "map"))
    assert bench.shows(lambda parts: parts.get("plan") and parts.get("rollouts") and parts.get("free"))
    assert bench.parts["plan"] == {
        "stamp": 12.0, "times": [0, 1000, 2000], "path": [0, 200, 100, 200, 200, 200],
        "contacts": [300, 400, -500, 250, 500],
    }  # fmt: skip
    assert [each["cost"] for each in bench.parts["rollouts"]] == [1.25, 3.5]
    assert bench.parts["free"] == [1000, 0, 0, 1000]
    rows = np.array([[1.0, 0.5, -0.4, 0.2, 0.15]])
    for topic, movers in (("ground_truth/movers", rows), ("movers", rows[:0])):
        publisher = ros.publisher(MarkerArray, topic, EVENT)
        assert ros.wait_until(lambda publisher=publisher: publisher.get_subscription_count() == 1)
        publisher.publish(movers_to_markers(7.5, movers, "map"))
    assert bench.shows(lambda parts: {"movers", "found"} <= parts.keys())
    assert bench.parts["movers"] == {"stamp": 7.5, "at": [1000, 500, -400, 200, 150]}
    assert bench.parts["found"] == {"stamp": 7.5, "at": []}
    contact = Impact(5.0, np.array([0.1, 0.2]), np.array([0.0, 1.0]), np.zeros(2), np.zeros(2))
    ros.publisher(PointCloud2, "impact/contact", EVENT).publish(impact_to_cloud(contact, "map"))
    bench.latched(DiagnosticStatus, "controller/state", state_message("/controller_node", reason="<b>so</b>"))
    bench.latched(DiagnosticStatus, "robot/state", state_message("/driver_node", state="held", reason="just started"))
    costs = status_message("/planner_node", OK, "", {"planning_time_ms": 12.5, "total": 3.0})
    ros.publisher(DiagnosticArray, "planner/costs", EVENT).publish(DiagnosticArray(status=[costs]))
    commands = ros.publisher(Twist, "cmd_vel", NEWEST)
    for _ in range(4):
        commands.publish(Twist())
        ros.spin(0.05)
    assert bench.shows(lambda parts: {"impacts", "doing", "hold", "costs", "periods"} <= parts.keys())
    assert [(each["at"], each["kind"]) for each in bench.parts["impacts"]] == [([100, 200], "other")]
    assert bench.parts["doing"]["reason"] == "<b>so</b>"
    assert bench.parts["hold"] == {"state": "held", "message": "just started"}
    assert bench.parts["costs"]["terms"] == {"total": 3.0}


def simulator(world, radius):
    given = [Parameter("simulator.world", value=world), Parameter("robot.radius", value=radius)]
    return lambda **kwargs: Other("simulator_node", Simulation, Robot, **{**kwargs, "parameter_overrides": given})


def test_a_node_that_was_started_again_is_asked_again_and_one_that_is_gone_holds_no_more(ros, bench):
    def shows(world, radius):
        about = lambda parts: parts.get("about", {})  # noqa: E731
        return bench.shows(
            lambda parts: (about(parts).get("world"), about(parts).get("radius")) == (world, radius), 30.0
        )

    first = ros.make(simulator("corridor", 0.12))
    bench.latched(DiagnosticStatus, "robot/state", state_message("/simulator_node", state="free"))
    assert shows("corridor", 120)
    assert bench.shows(lambda parts: parts["world"] and parts["about"]["robot"] == "simulated", 30.0)
    assert len(bench.parts["world"]["polygons"]) > 2
    ros.remove(first)
    again = ros.make(simulator("slalom", 0.15))  # sooner than the first one counts as silent
    assert shows("slalom", 150)
    assert bench.shows(lambda parts: parts["world"])
    ros.remove(again)
    assert bench.shows(lambda parts: any(node["silent"] for node in parts["nodes"]))
    assert shows("", round(1e3 * Robot().radius))
    assert bench.parts["world"] is None


# ---- what a page can do


def test_a_click_gives_a_goal(ros, bench):
    assert not bench.ask(do="goal", x=1.5, y=-0.5)[0]
    goals = ros.listen(PoseStamped, "goal_pose", EVENT)
    assert ros.wait_until(lambda: bench.node.count_subscribers("goal_pose") > 1)
    assert bench.ask(do="goal", x=1.5, y=-0.5)[0]
    assert ros.wait_until(lambda: goals)
    assert (goals[0].header.frame_id, goals[0].pose.position.x, goals[0].pose.position.y) == ("map", 1.5, -0.5)


def offered(ros, bench, name, called, namespace=""):
    def serve(request, response):
        called.append(name)
        response.success, response.message = True, "as you say"
        return response

    ros.probe.create_service(Trigger, f"{namespace}{name}", serve)
    client = next(client for client in bench.node.clients if client.srv_name == name)
    assert ros.wait_until(client.service_is_ready)


def test_services_are_called_and_a_stop_goes_before_what_waits(ros, bench):
    called, names = [], ["estop", "cancel", "resume", "clear_estop"]
    for name in names:
        done, text = bench.ask(do=name)
        assert (done, f"/{name}" in text) == (False, True)
    for name in names:
        offered(ros, bench, name, called)
        assert bench.ask(do=name) == (True, "as you say")
    assert called == names
    called.clear()
    for number, name in enumerate(["cancel", "cancel", "cancel", "estop"]):
        bench.page.send(json.dumps({"token": bench.token, "number": 100 + number, "do": name}))
    time.sleep(1.0)  # all have come before the node looks
    assert ros.wait_until(lambda: len(called) == 4)
    assert called[0] == "estop"


def test_the_strategy_is_shown_and_chosen(ros, bench):
    assert bench.ask(do="strategy", name="bounce")[0] is False
    other = ros.make(lambda **kwargs: Other("planner_node", Planning, **kwargs))
    assert bench.shows(lambda parts: parts.get("strategy"))
    assert {"bounce", "harness"} <= set(bench.parts["strategy"]["choices"])
    assert bench.ask(do="strategy", name="bounce") == (True, "planner.strategy is bounce")
    assert other.get_parameter("planner.strategy").value == "bounce"
    done, text = bench.ask(do="strategy", name="none of them")
    assert (done, "planner.strategy" in text) == (False, True)
    # what somebody else sets is seen
    other.set_parameters([Parameter("planner.strategy", value="avoid")])
    assert bench.shows(lambda parts: parts["strategy"]["value"] == "avoid")


# ---- whatever comes


def test_messages_that_nobody_expects_end_nothing(ros, bench):
    health = NodeHealth(ros, "/view_node")
    robot = FakeRobot(ros, hall())
    for scan in robot.bad_scans():
        ros.publisher(LaserScan, "scan", SENSOR_DATA).publish(scan)
    for pose in robot.bad_poses():
        robot.poses.publish(pose)
    far = robot.pose()
    far.pose.pose.position.x = 1e300
    robot.poses.publish(far)
    ros.publisher(Path, "plan", NEWEST).publish(Path(header=header(1.0, "elsewhere")))
    for topic in ("planner/seen", "planner/compared", "planner/trajectory", "impact/contact"):
        ros.publisher(PointCloud2, topic, LATCHED).publish(PointCloud2(header=header(1.0, "map"), width=7))
    ros.publisher(DiagnosticArray, "planner/costs", EVENT).publish(DiagnosticArray(status=[DiagnosticStatus()]))
    ros.publisher(PoseStamped, "goal_pose", EVENT).publish(PoseStamped())
    ros.publisher(DiagnosticArray, "/diagnostics", DIAGNOSTICS_PUBLISHED).publish(
        DiagnosticArray(status=[DiagnosticStatus(name="/\udcff".encode(errors="replace").decode()), DiagnosticStatus()])
    )
    robot.position = np.array([0.75, 0.0])
    assert bench.shows(lambda parts: parts.get("robot", [0])[0] == 750)
    assert health.counts("unread", 5)
    assert health.value("newest_unread")


def test_without_a_page_nothing_is_listened_to(ros, monkeypatch):
    monkeypatch.setattr(view_node, "LINGER", 0.3)
    FakeRobot(ros, hall())
    with ExitStack() as stack:
        bench = Bench(ros, stack)
        assert bench.shows(lambda parts: "robot" in parts)
        assert ros.probe.count_subscribers("mocap/odom") == 1
    assert ros.wait_until(lambda: ros.probe.count_subscribers("mocap/odom") == 0)
    assert ros.probe.count_subscribers("scan") == 0
    # a goal given meanwhile is known when somebody looks again
    ros.publisher(PoseStamped, "goal_pose", EVENT).publish(goal_to_message(np.array([1.0, 2.0]), "map"))
    ros.spin(0.5)
    with ExitStack() as stack:
        bench.open(stack)
        assert bench.shows(lambda parts: parts.get("goal", {}).get("at") == [1000, 2000] and "robot" in parts)


def test_in_a_namespace_it_shows_and_drives_that_robot_alone(ros, stack):
    bench = Bench(ros, stack, namespace="/robot1")
    called = []
    offered(ros, bench, "estop", called, "/robot1/")
    for name in ("/robot1/planner_node", "/planner_node", "/robot2/planner_node"):
        status = status_message(name, OK, "fine", {})
        ros.publisher(DiagnosticArray, "/diagnostics", DIAGNOSTICS_PUBLISHED).publish(DiagnosticArray(status=[status]))
    assert bench.shows(lambda parts: parts.get("nodes"))
    assert {node["name"].rpartition("/")[0] for node in bench.parts["nodes"]} == {"/robot1"}
    assert bench.ask(do="estop")[0]
    assert called == ["estop"]
