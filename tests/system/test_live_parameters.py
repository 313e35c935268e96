"""Each live parameter of each node: what is set there is held there, or refused. test_live_changes: what it does."""

import pytest
from live_parameters import IN_USE, LIVE, accepted, others
from rclpy.parameter import Parameter

from collplan_core.parameters import all_specs
from omnipuck_driver.driver_node import DriverNode
from omnipuck_sim.node.simulator_node import SimulatorNode


@pytest.mark.parametrize("kind", IN_USE, ids=lambda kind: kind.__name__)
def test_what_is_set_live_is_used_or_refused(ros, tmp_path, kind):
    node = ros.make(kind, {"emulator.link": str(tmp_path / "line"), "driver.port": str(tmp_path / "line")})
    before = IN_USE[kind](node).values()
    taken = []
    for spec in LIVE:
        if not node.has_parameter(spec.key):
            continue
        value = others(spec)[0]
        (result,) = node.set_parameters([Parameter(spec.key, value=value)])
        used = IN_USE[kind](node).values()[spec.key]
        if result.successful:
            taken.append(spec)
            assert used == value != before[spec.key], spec.key
        else:
            assert "read-only" in result.reason, f"{spec.key}: {result.reason}"
            assert used == before[spec.key] == node.get_parameter(spec.key).value, spec.key
    assert taken == accepted(node)
    assert taken


def test_every_live_parameter_is_taken_by_some_node(ros, tmp_path):
    line = {"emulator.link": str(tmp_path / "line"), "driver.port": str(tmp_path / "line")}
    nodes = [ros.make(kind, line) for kind in IN_USE]
    for spec in LIVE:
        assert any(spec in accepted(node) for node in nodes), spec.key


@pytest.mark.parametrize("kind", [SimulatorNode, DriverNode], ids=lambda kind: kind.__name__)
def test_nothing_live_raises_the_cap_of_a_robot(ros, tmp_path, kind):
    node = ros.make(kind, {"driver.port": str(tmp_path / "line"), "cap.speed": 0.8, "robot.max_speed": 0.5})
    (result,) = node.set_parameters([Parameter("robot.max_speed", value=0.9)])
    assert (result.successful, result.reason) == (
        False,
        "robot.max_speed: got 0.9, expected at most cap.speed, 0.8 m/s",
    )
    for key in ("cap.speed", "cap.acceleration", "limits.command_age", "limits.excess_speed"):
        (result,) = node.set_parameters([Parameter(key, value=0.4)])
        assert not result.successful, key


@pytest.mark.parametrize("key", ["limits.pose_age", "limits.scan_age", "limits.plan_age", "limits.command_age"])
def test_no_age_can_be_set_to_blindness(key):
    assert all_specs()[key].high <= {"limits.plan_age": 2.0, "limits.scan_age": 0.6}.get(key, 0.5)
