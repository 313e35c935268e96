"""Which robot moves: a simulated one must never be taken for a real one, nor the other way round."""

from collections.abc import Iterable, Mapping

from collplan_ros.view.scene import EMULATED, REAL, SIMULATED, UNKNOWN

Values = Mapping[str, object]
"""Parameters of a node by name."""


def which_robot(source: str, known: Mapping[str, Values], nodes: Iterable[str]) -> str:
    """Which robot it is that says how it is, by the parameters that its node has; UNKNOWN as long as there is doubt.

    Args:
        source: full name of the robot's node.
        known: parameters of the nodes that were asked and have answered, by full name.
        nodes: full names of all nodes heard of.
    """
    own = known.get(source)
    if own is None:
        return UNKNOWN
    if any(name.startswith("simulator.") for name in own):
        return SIMULATED
    port = own.get("driver.port")
    if not isinstance(port, str):
        return UNKNOWN
    links = [values["emulator.link"] for values in known.values() if "emulator.link" in values]
    if port in links:
        return EMULATED
    # one that has not answered may be the emulated firmware, and one there is may be at the port by another name
    in_doubt = links or not set(nodes) <= known.keys()
    return UNKNOWN if in_doubt or not port.startswith("/dev/") or port.startswith("/dev/pts/") else REAL
