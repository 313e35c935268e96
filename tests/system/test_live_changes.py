"""Each live parameter of each node, set while it runs: it is refused, or what comes out afterwards is not the same."""

import pytest
from live_loops import CONTROLLER_SCENES, PLANNER_SCENES, changes_loop
from live_nodes import COURSES, changes_course
from live_parameters import LIVE, NODES, accepted, others
from rclpy.parameter import Parameter

from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.planner_node import PlannerNode

SCENES = {PlannerNode: (PlannerLoop, PLANNER_SCENES), ControllerNode: (ControllerLoop, CONTROLLER_SCENES)}


@pytest.mark.parametrize("kind", NODES, ids=lambda kind: kind.__name__)
def test_what_is_set_live_is_refused_or_changes_what_comes_out(ros, tmp_path, kind):
    assert (kind in SCENES) != (kind in COURSES), "no scene shows what this node does"
    node = ros.make(kind, {"emulator.link": str(tmp_path / "line"), "driver.port": str(tmp_path / "line")})
    taken = accepted(node)
    assert taken
    for spec in LIVE:
        if node.has_parameter(spec.key) and spec not in taken:
            (result,) = node.set_parameters([Parameter(spec.key, value=others(spec)[0])])
            assert not result.successful, spec.key
            assert "read-only" in result.reason, spec.key
    changes = changes_loop(*SCENES[kind]) if kind in SCENES else changes_course(ros, kind)
    unheeded = [spec.key for spec in taken if not changes(spec)]
    assert not unheeded, f"{kind.__name__} takes these and goes on as before: {', '.join(unheeded)}"
