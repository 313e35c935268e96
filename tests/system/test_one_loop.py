"""Trial and graph decide alike: the inputs of a trial, fed to the nodes as messages, give equal plans and commands."""

import pytest
from called_nodes import give, tick
from nav_msgs.msg import Path
from rclpy.serialization import deserialize_message, serialize_message

from collplan_core.ages import StallGuard
from collplan_core.deadline import never
from collplan_core.goal import Goal
from collplan_core.loop import closed_loop
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.decisions import Cycle
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.parameters import Settings
from collplan_core.planners import map_period_of
from collplan_core.worlds import load_world
from collplan_ros.messages import conversions, reading
from collplan_ros.messages.cloud_reading import plan_from_message
from collplan_ros.messages.planner_clouds import plan_to_message
from collplan_ros.messages.raw_reading import plan_from_path, state_from_bytes
from collplan_ros.messages.raw_writing import plan_to_path
from collplan_ros.messages.states import goal_from_status, goal_to_status
from collplan_ros.node_kit import graph_node
from collplan_ros.nodes import planner_node
from collplan_ros.nodes.controller_node import ControllerNode
from omnipuck_sim import trial

MAP, BASE = "map", "base_link"
RUNS = (("corridor", "harness"), ("random:7", "low_risk"), ("u:17", "bounce"))


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


class Loops:
    """The two loops as a trial feeds them."""

    def __init__(self, strategy):
        settings = settings_of(strategy)
        self.planner, self.controller = PlannerLoop(settings, lambda settings: never), ControllerLoop(settings)
        self.plans, self.statuses, self.commands = [], [], []

    def take(self, kind, message, local):
        if kind == "mocap/odom":
            state = state_from_bytes(serialize_message(message), MAP, BASE)
            self.controller.take_pose(state, local)
            self.pass_on(self.planner.take_pose(state, local), local)
        elif kind == "scan":
            scan = reading.scan_from_message(message, BASE)
            self.controller.take_scan(scan, local)
            self.planner.take_scan(scan, local)
        elif kind == "impact":
            self.pass_on(self.planner.take_impact(*reading.impact_from_message(message, MAP), local), local)
        elif kind == "goal_pose":
            position = reading.goal_from_message(message, MAP)
            self.pass_on(self.planner.take_goal(bytes(16), position, local), local)
        elif kind == "planner":
            self.pass_on(self.planner.cycle(local), local)
        else:
            command = self.controller.tick(local)
            self.planner.take_command(command.velocity, local)
            self.commands.append(conversions.command_to_twist(command))

    def pass_on(self, decisions, local):
        for decision in decisions:
            if isinstance(decision, Goal):
                self.statuses.append(decision.status)
                self.controller.take_goal(goal_from_status(goal_to_status(decision)))
            elif isinstance(decision, Cycle):
                path, whole = plan_to_path(decision.plan, MAP), decision.plan
                self.plans.append(deserialize_message(path, Path))
                told = plan_from_message(plan_to_message(whole, MAP), MAP)
                alone = plan_from_path(path, MAP)
                assert told.stamp == alone.stamp
                assert told.times == pytest.approx(alone.times, rel=0.0, abs=1e-9)  # those of a Path are in nanoseconds
                assert told.positions.tolist() == alone.positions.tolist()
                self.controller.take_plan(told, local)


class Nodes:
    """The two nodes, with the time of a trial, their callbacks called one by one, what they publish handed on."""

    def __init__(self, ros, strategy, monkeypatch):
        self.local, self.settings = 0.0, settings_of(strategy)
        monkeypatch.setattr(graph_node, "seconds", lambda clock: self.local)
        # nothing runs here between two callbacks, however long one takes
        monkeypatch.setattr(StallGuard, "tick", lambda self, *now: False)
        overrides = {"planner.strategy": strategy}
        self.planner, self.controller = (
            ros.make(planner_node.PlannerNode, overrides),
            ros.make(ControllerNode, overrides),
        )
        # as in a trial the controller has a pose or a scan before the planner plans with it
        self.nodes = self.controller, self.planner
        self.plans, self.statuses, self.commands = [], [], []
        for node in self.nodes:
            for publisher in node.publishers:
                name = publisher.topic_name.removeprefix("/")
                publisher.publish = lambda message, name=name, kind=publisher.msg_type: self.hear(
                    name, deserialize_message(message, kind) if isinstance(message, bytes) else message
                )

    def hear(self, name, message):
        if name == "plan":
            self.plans.append(message)
        elif name == "goal_status":
            self.statuses.append(goal_from_status(message).status)
        elif name == "cmd_vel":
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


@pytest.mark.parametrize(("world", "strategy"), RUNS)
def test_equal_inputs_give_equal_decisions(ros, monkeypatch, world, strategy):
    events = recorded(world, strategy, monkeypatch)
    monkeypatch.setattr(planner_node, "deadlines", lambda clock: lambda settings: never)
    loops, nodes = Loops(strategy), Nodes(ros, strategy, monkeypatch)
    for event in events:
        loops.take(*event)
        nodes.take(*event)
    assert len(loops.plans) > 8
    assert "executing" in loops.statuses
    assert any(command.linear.x for command in loops.commands)
    assert nodes.statuses == loops.statuses
    assert nodes.plans == loops.plans
    assert nodes.commands == loops.commands
    if strategy == "bounce":
        assert "impact" in {kind for kind, _, _ in events}
