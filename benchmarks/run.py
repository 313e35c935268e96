"""Measures speed beside other programs and beside 1.0.0: writes a JSON file, prints a table with the targets."""

import argparse
import json
import os
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from answering import SkippedError
from history import HISTORY, PICTURE, write_history
from logged import Logged, logged_states, settings_for, thinned
from over_release import RELEASE, over_release
from report import print_report
from side_by_side import beside_dwa, beside_irsim
from timing import in_turn, summary, time_each

from collplan_core import __version__
from collplan_core.strategies import PAPER_WEIGHTS
from collplan_core.warm_up import warm_up
from collplan_core.worlds import load_world
from collplan_study.run.provenance import git_state, platform_record
from omnipuck_sim.trial import run_trial

ARENAS = ["l_corridor", "slalom"]
CLUTTER = [f"random:{seed}" for seed in range(200, 210)]
BOUNCED = [f"{family}:100" for family in ("l", "u", "z", "baffles", "random", "serpentine")]
"""Worlds in which plans to the goal are logged; the study of bounces holds out others."""


def main() -> None:
    """Measure, write, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("runs/bench.json"), help="file written (%(default)s)")
    parser.add_argument("--rounds", type=int, default=7, help="rounds of each comparison (%(default)s)")
    parser.add_argument("--no-peers", dest="peers", action="store_false", help="leave the programs from PyPI out")
    kept = f"leave {HISTORY.name} and its picture as they are"
    parser.add_argument("--no-history", dest="history", action="store_false", help=kept)
    options = parser.parse_args()
    warm_up()
    when = {"time": datetime.now(timezone.utc).isoformat(timespec="seconds"), "load_average": os.getloadavg()}
    made = {"version": __version__, "commit": git_state(), "simulated": True, "machine": platform_record() | when}
    figures = made | measured(options.rounds, options.peers)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
    print_report(figures)
    print(f"\nwritten to {options.out}")
    if options.history:
        write_history(figures)
        print(f"{__version__} is entered in {HISTORY}, drawn in {PICTURE}")


def measured(rounds: int, peers: bool) -> dict[str, Any]:
    """Every figure but those of the machine."""
    print("Logging states from runs ...", flush=True)
    corridor = load_world("corridor")
    inside = logged_states(PAPER_WEIGHTS, ["corridor"], range(4))
    elsewhere = logged_states(PAPER_WEIGHTS, ARENAS, range(4)) + logged_states(PAPER_WEIGHTS, CLUTTER, range(1))
    states, plans = inside + elsewhere, logged_states(["bounce"], BOUNCED, range(1), every=4)
    print("Timing ...", flush=True)

    def trial(strategy: str, seed: int) -> list[float]:
        return time_each(lambda settings: run_trial(corridor, settings, seed), [settings_for(strategy)])

    measures = {
        "cycle": lambda _: time_each(Logged.plan, thinned(states, 300)),
        "plan_to_goal": lambda _: time_each(Logged.plan, plans),
        "trial_harness": lambda seed: trial("harness", seed),
        "trial_bounce": lambda seed: trial("bounce", seed),
    }
    figures: dict[str, Any] = {name: summary(each) for name, each in in_turn(measures, rounds).items()}
    figures["trials_per_second"] = {name: 1e6 / figures[f"trial_{name}"]["median_us"] for name in ("harness", "bounce")}
    beside = {RELEASE: lambda: over_release(rounds)}
    if peers:
        beside["ir-sim"] = lambda: beside_irsim(corridor, thinned(inside, 200), rounds)
        beside["dynamic-window-approach"] = lambda: beside_dwa(thinned(states, 60), rounds)
    figures["comparisons"], figures["skipped"] = {}, {}
    for name, compare in beside.items():
        try:
            figures["comparisons"] |= compare()
        except SkippedError as error:
            figures["skipped"][name] = str(error)
    figures["ratios"] = {name: each.pop("ratio") for name, each in figures["comparisons"].items()}
    return figures


if __name__ == "__main__":
    main()
