"""Each live parameter of planner and controller, set while it runs: what comes out afterwards is not the same."""

import pytest
from live_loops import CONTROLLER_SCENES, PLANNER_SCENES, changes_loop
from live_parameters import LIVE, NODES, accepted, others
from rclpy.parameter import Parameter

from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.planner_node import PlannerNode

SCENES = {PlannerNode: (PlannerLoop, PLANNER_SCENES), ControllerNode: (ControllerLoop, CONTROLLER_SCENES)}


def test_what_is_not_live_at_a_node_is_refused(ros, tmp_path):
    for kind in NODES:
        line = str(tmp_path / kind.__name__)
        node = ros.make(kind, {"emulator.link": line, "driver.port": line})
        taken = accepted(node)
        assert taken, kind
        for spec in LIVE:
            if node.has_parameter(spec.key) and spec not in taken:
                (result,) = node.set_parameters([Parameter(spec.key, value=others(spec)[0])])
                assert "read-only" in result.reason, spec.key
        ros.remove(node)


@pytest.mark.parametrize("kind", SCENES, ids=lambda kind: kind.__name__)
def test_what_is_set_live_changes_what_comes_out(ros, kind):
    changes = changes_loop(*SCENES[kind])
    unheeded = [spec.key for spec in accepted(ros.make(kind)) if not changes(spec)]
    assert not unheeded, f"{kind.__name__} takes these and goes on as before: {', '.join(unheeded)}"
