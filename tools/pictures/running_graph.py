"""Who publishes what and who listens, asked of the nodes themselves while they run."""

import os
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.logging import LoggingSeverity, set_logger_level
from rclpy.node import Node
from rclpy.parameter import Parameter

from collplan_ros.bringup.network import environment_set, graph_environment
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.lidar_node import LidarNode
from collplan_ros.nodes.mocap_node import MocapNode
from collplan_ros.nodes.planner_node import PlannerNode
from collplan_ros.nodes.teleop_node import TeleopNode
from collplan_ros.nodes.view_node import ViewNode
from omnipuck_driver.driver_node import DriverNode
from omnipuck_sim.emulator.firmware_emulator import FirmwareEmulator
from omnipuck_sim.node.simulator_node import SimulatorNode

NODES = (
    SimulatorNode,
    FirmwareEmulator,
    DriverNode,
    MocapNode,
    LidarNode,
    PlannerNode,
    ControllerNode,
    TeleopNode,
    ViewNode,
)
OF_EVERY_NODE = {"/rosout", "/parameter_events", "/diagnostics", "/shared_constants"}
DOMAIN = "101"
"""The ROS domain used here; the tests take lower ones."""
PATIENCE = 30.0
"""For the driver to hear from the firmware that the ring senses impacts [s]."""
SPIN_TIME = 0.02


class Topics(NamedTuple):
    """The topics of one node without the leading slash, each with its message type."""

    published: dict[str, str]
    subscribed: dict[str, str]


def topics_by_node() -> dict[str, Topics]:
    """The topics of every node but those that each node has, from nodes that run in this process.

    Raises:
        TimeoutError: driver and firmware do not find each other.
    """
    with _running_nodes() as nodes:
        return {node.get_name(): _topics(node) for node in nodes}


@contextmanager
def _running_nodes() -> Iterator[list[Node]]:
    with ExitStack() as stack:
        local = {**graph_environment("local", os.environ), "ROS_DOMAIN_ID": DOMAIN}
        stack.enter_context(environment_set(local))
        link = Path(stack.enter_context(TemporaryDirectory())) / "serial"
        context = Context()
        context.init()
        set_logger_level("", LoggingSeverity.WARN)
        stack.callback(set_logger_level, "", LoggingSeverity.INFO)
        stack.callback(context.try_shutdown)
        parameters = {
            "emulator.link": str(link),
            "driver.port": str(link),
            "emulator.senses_impacts": True,
            "view.port": 0,
        }
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        executor = SingleThreadedExecutor(context=context)
        nodes = []
        for kind in NODES:
            nodes.append(kind(context=context, parameter_overrides=overrides))
            stack.callback(nodes[-1].destroy_node)
        for node in nodes:
            if isinstance(node, FirmwareEmulator | DriverNode):
                executor.add_node(node)
        stack.callback(executor.shutdown)
        _spin_until_impacts_are_sensed(executor, next(node for node in nodes if isinstance(node, DriverNode)))
        yield nodes


def _spin_until_impacts_are_sensed(executor: SingleThreadedExecutor, driver: DriverNode) -> None:
    end = time.monotonic() + PATIENCE
    while "impact" not in _topics(driver).published:
        if time.monotonic() > end:
            raise TimeoutError(f"driver_node does not publish impact {PATIENCE:g} s after the firmware is there")
        executor.spin_once(timeout_sec=SPIN_TIME)


def _topics(node: Node) -> Topics:
    named = node.get_name(), node.get_namespace()
    return Topics(
        _own(node.get_publisher_names_and_types_by_node(*named)),
        _own(node.get_subscriber_names_and_types_by_node(*named)),
    )


def _own(found: list[tuple[str, list[str]]]) -> dict[str, str]:
    return {name.removeprefix("/"): kinds[0].rpartition("/")[2] for name, kinds in found if name not in OF_EVERY_NODE}
