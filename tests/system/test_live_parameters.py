"""Each live parameter of each node: what is set there is used there, or refused."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest
from rclpy.parameter import Parameter

from collplan_core.parameters import all_specs
from collplan_core.parameters.spec import Spec
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.lidar_node import LidarNode
from collplan_ros.nodes.mocap_node import MocapNode
from collplan_ros.nodes.planner_node import PlannerNode
from omnipuck_driver.driver_node import DriverNode
from omnipuck_sim.emulator.firmware_emulator import FirmwareEmulator
from omnipuck_sim.node.simulator_node import SimulatorNode

SOURCES = Path(__file__).parents[2] / "src"
LIVE = [spec for spec in all_specs().values() if spec.live]
IN_USE = {
    MocapNode: lambda node: node._settings,
    LidarNode: lambda node: node._settings,
    PlannerNode: lambda node: node._loop._settings,
    ControllerNode: lambda node: node._loop._settings,
    SimulatorNode: lambda node: node._contract._check._settings,
    DriverNode: lambda node: node._contract._check._settings,
    FirmwareEmulator: lambda node: node._settings,
}
"""The settings that each node decides by."""
SHARE = 0.03
"""How far into its range a number is set: a stall of the emulated firmware is to be short."""


def another(spec: Spec):
    """A value other than the default."""
    if isinstance(spec.default, bool):
        return not spec.default
    if spec.choices:
        return next(choice for choice in spec.choices if choice != spec.default)
    value = spec.low + SHARE * (spec.high - spec.low)
    if isinstance(spec.default, int):
        value = round(value)
    return value if value != spec.default else spec.low


@cache
def imported(module: str) -> frozenset[str]:
    """The modules of the project that a module imports, by whatever way, itself included."""
    found, new = set(), {module}
    while new:
        name = new.pop()
        found.add(name)
        new |= {each for each in _imports(name) if _path(each).exists()} - found
    return frozenset(found)


def _path(module: str) -> Path:
    place = SOURCES / module.split(".")[0] / Path(*module.split("."))
    return place / "__init__.py" if place.is_dir() else place.with_suffix(".py")


def _imports(module: str) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(_path(module).read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return found


def is_read(spec: Spec, node: type) -> bool:
    """Whether the code that a node runs reads the parameter."""
    _, name = spec.key.split(".")
    texts = (_path(each).read_text(encoding="utf-8") for each in imported(node.__module__))
    return any(re.search(rf"\.{name}\b", text) for text in texts)


@pytest.mark.parametrize("kind", IN_USE, ids=lambda kind: kind.__name__)
def test_what_is_set_live_is_used_or_refused(ros, tmp_path, kind):
    node = ros.make(kind, {"emulator.link": str(tmp_path / "line"), "driver.port": str(tmp_path / "line")})
    before = IN_USE[kind](node).values()
    accepted = []
    for spec in LIVE:
        if not node.has_parameter(spec.key):
            continue
        (result,) = node.set_parameters([Parameter(spec.key, value=another(spec))])
        used = IN_USE[kind](node).values()[spec.key]
        if result.successful:
            accepted.append(spec.key)
            assert used == another(spec) != before[spec.key], spec.key
            assert is_read(spec, kind), f"{spec.key} is taken by {kind.__name__} and read by nothing it runs"
        else:
            assert "read-only" in result.reason, f"{spec.key}: {result.reason}"
            assert used == before[spec.key] == node.get_parameter(spec.key).value, spec.key
    assert accepted


def test_every_live_parameter_is_taken_by_some_node(ros, tmp_path):
    line = {"emulator.link": str(tmp_path / "line"), "driver.port": str(tmp_path / "line")}
    nodes = [ros.make(kind, line) for kind in IN_USE]
    for spec in LIVE:
        takers = [n for n in nodes if n.has_parameter(spec.key) and not n.describe_parameter(spec.key).read_only]
        assert takers, spec.key


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
