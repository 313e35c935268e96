"""Report of how simulated time keeps step with the graph, among simulator_node's values on /diagnostics."""

from collections.abc import Mapping
from typing import NamedTuple

from collplan_ros.messages.reading import check_finite

FACTOR, WAIT, WAITED_FOR = "real_time_factor", "longest_wait_s", "longest_wait_for"


class LockstepReport(NamedTuple):
    """Simulated seconds in the last second; the longest wait for a node so far [s], and for which; "" before any."""

    factor: float
    longest_wait: float
    waited_for: str


def lockstep_of(values: Mapping[str, str]) -> LockstepReport | None:
    """Returns the lockstep report among a node's values; None where the node is not in lockstep.

    Raises:
        ValueError: a figure is no finite number.
    """
    if FACTOR not in values:
        return None
    report = LockstepReport(float(values[FACTOR]), float(values.get(WAIT, "0")), values.get(WAITED_FOR, ""))
    check_finite("/diagnostics", report.factor, report.longest_wait)
    return report
