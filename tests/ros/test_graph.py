"""All nodes in one process, driving the simulated robot."""

import numpy as np
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.parameter import Parameter

from collplan_core.worlds import load_world
from collplan_ros.messages.qos import EVENT
from simulated_graph import Graph


def test_each_strategy_takes_over_from_any_other_while_the_robot_drives(ros):
    """The strategy is set at planner_node alone."""
    few = {"time_to_goal__proposals": 20, "time_to_goal__time_budget": 1.0}
    graph = Graph(ros, "corridor", planner__map_period=0.1, **few)
    costs = ros.listen(DiagnosticArray, "planner/costs", EVENT)

    def plans_by(strategy) -> int:
        return sum(value.value == strategy for each in costs for value in each.status[0].values)

    graph.send_goal(load_world("corridor").goal)
    for strategy in ("harness", "bounce", "high_risk", "tolerate", "avoid", "low_risk", "stop_guarantee"):
        before = plans_by(strategy)
        assert graph.planner.set_parameters([Parameter("planner.strategy", value=strategy)])[0].successful
        planned = ros.wait_until(
            lambda strategy=strategy, before=before: plans_by(strategy) >= before + 2, clock=lambda: graph.state.stamp
        )
        assert planned, strategy
        assert graph.status == GoalStatus.STATUS_EXECUTING, "the way is too short for seven strategies"
    maneuvers = [maneuver.data for maneuver in graph.maneuvers]
    assert "stopped" not in maneuvers[maneuvers.index("free_space") :], maneuvers
    # it may have touched a wall just now
    assert ros.wait_until(lambda: np.hypot(*graph.state.velocity) > 0.2, clock=lambda: graph.state.stamp)
    assert ros.wait_until(lambda: graph.status == GoalStatus.STATUS_SUCCEEDED, clock=lambda: graph.state.stamp)
    assert np.hypot(*(graph.state.position - load_world("corridor").goal)) < 0.25
    graph.commands.clear()
    assert ros.wait_until(lambda: len(graph.commands) >= 2 and graph.maneuvers[-1].data == "stopped")
    last = graph.commands[-1]
    assert (last.linear.x, last.linear.y, last.angular.z) == (0.0, 0.0, 0.0)
