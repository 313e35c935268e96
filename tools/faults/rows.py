"""Every fault, and the bench of each robot."""

from collections.abc import Callable
from typing import Any

from faults import base, fuzz, goals, hands, held, learning, line, movers, nodes, order, poses, runs, stops, trials
from faults.base_graph import COMMANDED, BaseGraph
from faults.bench import Bench
from faults.fault import Fault
from faults.live_graph import LiveGraph

FAULTS: list[Fault] = [
    *stops.FAULTS,
    *hands.FAULTS,
    *nodes.FAULTS,
    *poses.FAULTS,
    *trials.FAULTS,
    *held.FAULTS,
    *learning.FAULTS,
    *goals.FAULTS,
    *line.FAULTS,
    *base.FAULTS,
    *movers.FAULTS,
    *runs.FAULTS,
    *fuzz.FAULTS,
    *order.FAULTS,
]
BENCHES: dict[str, Callable[[], Any]] = {
    "simulator": lambda: LiveGraph("sim"),
    "serial": lambda: LiveGraph("emulator"),
    base.BASE: lambda: BaseGraph(f"base:{COMMANDED}"),
    "bringup": runs.RunEnds,
    "process": Bench,
    "trial": Bench,
    "desk": Bench,
}
"""In the order in which they are opened."""
ASIDE = ("trial", "desk")
"""Those whose clock no machine stalls: they are done by a second process, which the others go before."""
