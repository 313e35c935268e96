"""The robots that bringup can start."""

from dataclasses import dataclass


@dataclass(frozen=True)
class RobotKind:
    """A robot's node, started by the name of its executable so that no package depends on it.

    Attributes:
        executable: name of the program.
        node: name of its node.
        simulated: whether its results are a simulation's.
        network: discovery range used unless another one is asked for.
    """

    executable: str
    node: str
    simulated: bool
    network: str


ROBOTS = {
    "sim": RobotKind(executable="simulator_node", node="simulator_node", simulated=True, network="local"),
}
NODES = ("mocap_node", "lidar_node", "planner_node", "controller_node")
"""What runs beside the robot; each executable is named like its node."""
