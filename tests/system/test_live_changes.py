"""Each live parameter that a node takes, set while it runs: what comes out afterwards is not what came without it."""

import pytest
from live_loops import CONTROLLER_SCENES, PLANNER_SCENES, changes_loop
from live_nodes import COURSES, changes_course
from live_parameters import IN_USE, accepted

from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.planner_node import PlannerNode

SCENES = {PlannerNode: PLANNER_SCENES, ControllerNode: CONTROLLER_SCENES}


@pytest.mark.parametrize("kind", IN_USE, ids=lambda kind: kind.__name__)
def test_what_is_set_live_changes_what_comes_out(ros, tmp_path, kind):
    assert (kind in SCENES) != (kind in COURSES), "no scene shows what this node does"
    node = ros.make(kind, {"emulator.link": str(tmp_path / "line"), "driver.port": str(tmp_path / "line")})
    changes = changes_loop(node, SCENES[kind]) if kind in SCENES else changes_course(ros, kind)
    unheeded = [spec.key for spec in accepted(node) if not changes(spec)]
    assert not unheeded, f"{kind.__name__} takes these and goes on as before: {', '.join(unheeded)}"
