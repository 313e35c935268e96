"""Identification of the moving robot: a simulated one must never be mistaken for a real one, or vice versa."""

from collections.abc import Collection, Mapping

from collplan_core.parameters.file import NODES
from collplan_ros.view.scene import EMULATED, REAL, SIMULATED, UNKNOWN

TELL = {*NODES} - {"view_node"}
"""Names of the nodes that tell their parameters."""
Values = Mapping[str, object]
"""Parameters of a node by name."""


def which_robot(source: str, known: Mapping[str, Values], nodes: Collection[str]) -> str:
    """Returns the kind of the reporting robot, by the parameters of its node; UNKNOWN as long as there is doubt.

    `source` is that node, `known` the parameters that nodes have told, `nodes` all that report, by full names.
    """
    own = known.get(source)
    there = [known[name] for name in {*nodes, source} if name in known]
    firmware = [values["emulator.link"] for values in there if "emulator.link" in values]
    if own is None or sum(map(_is_robot, there)) != 1 or not _is_robot(own):
        return UNKNOWN
    if _is_simulator(own):
        return SIMULATED
    port = own["driver.port"]
    if port in firmware:
        return EMULATED
    # one that has not told its own may be the emulated firmware, and one there is may be at the port by another name
    in_doubt = bool(firmware) or any(name.rpartition("/")[2] in TELL and name not in known for name in nodes)
    leads_to_hardware = isinstance(port, str) and port.startswith("/dev/") and not port.startswith("/dev/pts/")
    return REAL if leads_to_hardware and not in_doubt else UNKNOWN


def _is_robot(values: Values) -> bool:
    """Returns whether a node takes commands; the emulated firmware does not, the driver in front of it does."""
    return "emulator.link" not in values and ("driver.port" in values or _is_simulator(values))


def _is_simulator(values: Values) -> bool:
    return any(name.startswith("simulator.") for name in values)
