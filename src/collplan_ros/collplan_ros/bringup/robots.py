"""The robots that bringup can start."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from collplan_ros.bringup.failures import StartError

SERIAL, SIMULATOR = "serial", "simulator_node"


@dataclass(frozen=True)
class RobotKind:
    """A kind of robot; its nodes are started by executable name, so that this package does not depend on theirs.

    Attributes:
        nodes: its nodes, first the one that receives commands, then the devices behind it; each executable is named
            like its node.
        simulated: whether the motion of the robot is simulated.
        network: default discovery range, local or subnet; None where it is required on the command line.
        emulated: whether a pseudo-terminal replaces the serial device.
        values: parameters set for this robot, by key.
        in_one_process: whether its nodes can run in bringup's process, where simulated time waits for them.
    """

    nodes: tuple[str, ...]
    simulated: bool
    network: str | None
    emulated: bool = False
    values: Mapping[str, object] = field(default_factory=dict)
    in_one_process: bool = False


SPEED_FACTOR = "simulator.speed_factor"
EMULATOR = RobotKind(
    nodes=("driver_node", "firmware_emulator"),
    simulated=True,
    network="local",
    emulated=True,
    values={SPEED_FACTOR: 1.0},  # a serial line has real time
)
ROBOTS = {
    "sim": RobotKind(nodes=(SIMULATOR,), simulated=True, network="local", in_one_process=True),
    "emulator": EMULATOR,
    "emulator:c": replace(EMULATOR, values={**EMULATOR.values, "emulator.firmware": "c"}),
}
EXPECTED = f"{', '.join(ROBOTS)}, {SERIAL}:PATH or {SERIAL}:PATH@BAUD"
FIRST_SPEED = 0.3
"""Highest robot.max_speed of a robot that is not simulated, unless --max-speed is given [m/s]."""
COMMANDER, PLANNER = "controller_node", "planner_node"
"""The only node that commands the robot, and the one that takes goals."""
LIDAR = "lidar_node"
"""The node of SIM alone."""
NODES = ("mocap_node", LIDAR, PLANNER, COMMANDER)
"""Nodes that run beside every robot; each executable is named like its node."""
SIM, REAL = "sim", "real"
"""Source of the scans that the robot drives by: lidar_node, or a LIDAR whose driver is started elsewhere."""
VIEWER = "view_node"
"""The node of the live page, where it is asked for: a run goes on without it."""


def robot_kind(spec: str) -> RobotKind:
    """The robot kind for sim, emulator, serial:PATH or serial:PATH@BAUD.

    Raises:
        StartError: another specification.
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
    return RobotKind(nodes=("driver_node",), simulated=False, network=None, values=values)
