"""The robots that bringup can start."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from collplan_ros.bringup.failures import StartError

SERIAL = "serial"


@dataclass(frozen=True)
class RobotKind:
    """A robot's nodes, started by the names of their executables so that no package depends on them.

    Attributes:
        nodes: the one that takes commands comes first; each executable is named like its node.
        simulated: whether its results are a simulation's.
        network: discovery range used unless another one is asked for.
        emulated: whether a pseudo-terminal stands for the serial device.
        values: parameters that it sets, by key.
    """

    nodes: tuple[str, ...]
    simulated: bool
    network: str
    emulated: bool = False
    values: Mapping[str, object] = field(default_factory=dict)


ROBOTS = {
    "sim": RobotKind(nodes=("simulator_node",), simulated=True, network="local"),
    "emulator": RobotKind(nodes=("driver_node", "firmware_emulator"), simulated=True, network="local", emulated=True),
}
EXPECTED = f"{', '.join(ROBOTS)}, {SERIAL}:PATH or {SERIAL}:PATH@BAUD"
NODES = ("mocap_node", "lidar_node", "planner_node", "controller_node")
"""What runs beside the robot; each executable is named like its node."""


def robot_kind(spec: str) -> RobotKind:
    """The robot of a name, or the real one at a serial device.

    Raises:
        StartError: neither.
    """
    if spec in ROBOTS:
        return ROBOTS[spec]
    name, _, device = spec.partition(":")
    path, at, rate = device.rpartition("@") if "@" in device else (device, "", "")
    if name != SERIAL or not path or (at and not rate.isdecimal()):
        raise StartError(f"robot {spec!r}: unknown, expected one of {EXPECTED}")
    values: dict[str, object] = {"driver.port": path}
    if rate:
        values["driver.baud"] = int(rate)
    return RobotKind(nodes=("driver_node",), simulated=False, network="subnet", values=values)
