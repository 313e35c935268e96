"""The printed table: each figure beside its target."""

from collections.abc import Mapping, Sequence
from typing import Any

TARGETS: list[tuple[str, tuple[str, ...], float, bool]] = [
    ("scan over ir-sim's Lidar2D.step", ("ratios", "scan_vs_irsim"), 1 / 100, True),
    ("cycle over a dynamic-window step", ("ratios", "cycle_vs_dwa"), 1 / 100, True),
    ("cycle, pruned over unpruned", ("ratios", "cycle_pruned_vs_unpruned"), 0.8, True),
    ("walls of a noisy scan over a cycle", ("ratios", "wall_lines_vs_cycle"), 0.5, True),
    ("run over the same in ir-sim", ("ratios", "trial_vs_irsim"), 1 / 15, True),
    ("cycle [us, median]", ("cycle_pruned", "median_us"), 600.0, True),
    ("pruned aim near the unpruned [share]", ("pruning_agreement", "share"), 0.95, False),
    ("plan to the goal [us, median]", ("plan_to_goal", "median_us"), 20_000.0, True),
    ("plan to the goal [us, p99]", ("plan_to_goal", "p99_us"), 40_000.0, True),
    ("coarse rollouts that differ, a plan", ("rollouts", "counts", "rollouts"), 3000, False),
    ("changes tried a plan", ("rollouts", "counts", "proposals"), 1500, False),
]


def figure_at(figures: Mapping[str, Any], keys: Sequence[str]) -> Any:
    """Returns the figure under nested keys; None where a peer that would have given it was skipped."""
    value: Any = figures
    for key in keys:
        value = value.get(key) if value is not None else None
    return value


def verdicts(figures: dict[str, Any]) -> list[dict[str, Any]]:
    """Name, value, target and met (None where a peer was skipped) of each figure that has a target."""
    rows = []
    for name, keys, target, at_most in TARGETS:
        value = figure_at(figures, keys)
        met = None if value is None else (value <= target if at_most else value >= target)
        rows.append({"figure": name, "value": value, "target": target, "at_most": at_most, "met": met})
    return rows


def print_report(figures: dict[str, Any]) -> None:
    """Prints times, stages and targets."""
    where = figures["machine"]
    loads = f"load {where['load_average'][0]} before, {figures['load_average_after'][0]} after"
    print(f"\n{where['cpu']}, {where['cores']} cores, {loads}, Python {where['python']}")
    print(f"\n{'':38}{'median us':>11}{'p99 us':>11}{'n':>8}")
    for name in ("scan", "wall_lines", "local_map", "cycle_pruned", "cycle_unpruned", "trajectory"):
        print(_times(name, figures[name]))
    print(f"\n{'share of a cycle by stage':38}{_stages(figures['stages'])}")
    _print_rollouts(figures)
    for name, each in figures["trials_per_second"].items():
        print(f"{'trials a second, ' + name:38}{each:11.1f}")
    print(f"{'simulated seconds a second':38}{figures['trial_realtime_factor']['median']:11.1f}")
    print(f"{'steps a second of the environment':38}{figures['gym_steps_per_second']:11.0f}")
    for name, each in figures["protocol"].items():
        print(f"{name + ' [frames/s]':38}{each['frames_per_s']:11d}")
    for rate, share in figures["driver_cpu"].items():
        print(f"{'driver_node, share of a core at ' + rate:38}{share:11.1%}")
    print(f"\n{'':38}{'figure':>14}{'target':>14}")
    for row in figures["targets"]:
        print(_line(row))
    for peer, reason in figures["skipped"].items():
        print(f"skipped: {peer}: {reason}")


def _print_rollouts(all_figures: dict[str, Any]) -> None:
    figures = all_figures["rollouts"]
    print("\nplans to the goal, everything included, with their coarse rollouts:")
    print(_times("plan_to_goal", all_figures["plan_to_goal"]))
    print(_times("coarse", figures["coarse"]))
    print(f"{'steps of coarse rollouts a second':38}{all_figures['rollout_steps_per_second']:11d}")
    print(f"{'share of a plan by stage':38}{_stages(figures['stages'])}\n")


def _times(name: str, row: dict[str, Any]) -> str:
    return f"{name:38}{row['median_us']:11.1f}{row['p99_us']:11.1f}{row['n']:8d}"


def _stages(shares: dict[str, float]) -> str:
    return "  ".join(f"{name} {share:.0%}" for name, share in shares.items())


def _line(row: dict[str, Any]) -> str:
    bound = ("<= " if row["at_most"] else ">= ") + _number(row["target"])
    value = "skipped" if row["value"] is None else _number(row["value"])
    met = {None: "", True: "met", False: "missed"}[row["met"]]
    return f"{row['figure']:38}{value:>14}{bound:>14}  {met}"


def _number(value: float) -> str:
    if 0.0 < value < 0.1:
        return f"1/{1 / value:.0f}"
    return f"{value:.3g}" if value < 1000 else f"{value:.0f}"
