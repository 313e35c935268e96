"""The figures that are printed with their targets, and followed over the releases."""

from collections.abc import Mapping
from functools import reduce
from typing import Any, NamedTuple


class Figure(NamedTuple):
    """A figure's place in runs/bench.json, what it is called, and the most that it should be, if anything says so."""

    place: str
    name: str
    target: float | None = None

    def of(self, figures: Mapping[str, Any]) -> Any:
        """Its value; None where what would have given it was skipped."""
        return reduce(lambda value, key: None if value is None else value.get(key), self.place.split("."), figures)


PANELS: dict[str, tuple[Figure, ...]] = {
    "ratio of times": (
        Figure("ratios.scan_vs_irsim", "scan over ir-sim's", 1 / 100),
        Figure("ratios.cycle_vs_dwa", "cycle over a dynamic window's", 1 / 100),
        Figure("ratios.trial_vs_irsim", "run over ir-sim's", 1 / 15),
        Figure("ratios.trial_vs_irsim_at_pose_rate", "run over ir-sim's at 100 Hz"),
        Figure("ratios.trial_harness_vs_1_0_0", "trial over 1.0.0's, harness", 1.4),
        Figure("ratios.trial_bounce_vs_1_0_0", "trial over 1.0.0's, bounce", 1.1),
        Figure("ratios.trial_avoid_vs_1_0_0", "trial over 1.0.0's, avoid", 1.1),
    ),
    "time [us]": (
        Figure("cycle.median_us", "cycle", 600.0),
        Figure("plan_to_goal.median_us", "plan to the goal", 20_000.0),
        Figure("plan_to_goal.p99_us", "plan to the goal, p99", 40_000.0),
    ),
    "number a second": (
        Figure("trials_per_second.harness", "trials, harness"),
        Figure("trials_per_second.bounce", "trials, bounce"),
    ),
}
"""Figures by the panel of the picture that shows them."""


def print_report(figures: Mapping[str, Any]) -> None:
    """Prints the machine, the figures with their targets, and what was skipped."""
    where = figures["machine"]
    print(f"\n{where['processor']}, {where['cpus']} cores, load {where['load_average'][0]:.1f} before\n")
    for panel, shown in PANELS.items():
        for each in shown:
            value = each.of(figures)
            row = f"{panel:18}{each.name:32}" + ("   skipped" if value is None else f"{value:10.4g}")
            if value is not None and each.target is not None:
                row += f"   at most {each.target:.4g}: {'met' if value <= each.target else 'missed'}"
            print(row)
    for name, reason in figures["skipped"].items():
        print(f"skipped: {name}: {reason}")
