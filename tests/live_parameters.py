"""The nodes that take parameters while they run, and the values that tests set there."""

from collplan_core.parameters import all_specs
from collplan_core.parameters.spec import Spec
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.lidar_node import LidarNode
from collplan_ros.nodes.mocap_node import MocapNode
from collplan_ros.nodes.planner_node import PlannerNode
from omnipuck_driver.driver_node import DriverNode
from omnipuck_sim.emulator.firmware_emulator import FirmwareEmulator
from omnipuck_sim.node.simulator_node import SimulatorNode

LIVE = [spec for spec in all_specs().values() if spec.live]
NODES = (MocapNode, LidarNode, PlannerNode, ControllerNode, SimulatorNode, DriverNode, FirmwareEmulator)
SHARES = (0.03, 0.0, 0.3, 1.0)
"""How far into its range a number is set."""
LARGE = {"planner.goal_timeout": 1.2, "planner.longest_detour": 0.02}
"""Values of parameters for which a share of the range is too large for a test [s], [m]."""


def accepted(node) -> list[Spec]:
    """The live parameters that a node takes."""
    return [spec for spec in LIVE if node.has_parameter(spec.key) and not node.describe_parameter(spec.key).read_only]


def others(spec: Spec) -> list:
    """Values other than the default."""
    if spec.key in LARGE:
        return [LARGE[spec.key]]
    if isinstance(spec.default, bool):
        return [not spec.default]
    if spec.choices:
        return [choice for choice in spec.choices if choice != spec.default]
    values = [spec.low + share * (spec.high - spec.low) for share in SHARES]
    if isinstance(spec.default, int):
        values = [round(value) for value in values]
    return [value for value in values if value != spec.default]
