"""Measures speed beside other planners and simulators: writes a JSON file and prints a table with the targets."""

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from agreement import agreement
from alone import alone, gym_steps_per_second, realtime_factor, trials_per_second
from history import HISTORY, PICTURE, write_history
from logged import Logged, logged_states
from machine import load, machine
from peer import STEPS, Peer, PeerError, install
from report import print_report, verdicts
from rollouts import FAMILIES, logged_calls, rollouts
from serial_line import driver_cpu, protocol
from side_by_side import beside_dwa, beside_irsim_scan, beside_irsim_trial
from stages import stage_shares

from collplan_core import __version__
from collplan_core.warm_up import warm_up
from collplan_core.worlds import load_world
from collplan_study.run.provenance import git_state

ARENAS = ["corridor", "l_corridor", "slalom"]
CLUTTER = [f"random:{seed}" for seed in range(200, 210)]
SCAN_PERIOD, POSE_PERIOD = 0.05, 0.01


def main() -> None:
    """Measure, write, print."""
    options = parse_options()
    warm_up()
    machine_before = machine()
    print("Logging states from runs ...", flush=True)
    states = logged_states(ARENAS, range(options.seeds)) + logged_states(CLUTTER[: options.clutter], range(1))
    print(f"Timing {len(states)} states ...", flush=True)
    figures = measured(states, options)
    made = {"version": __version__, "commit": git_state(), "machine": machine_before, "load_average_after": load()}
    figures = {**made, "simulated": True, **figures}
    figures["targets"] = verdicts(figures)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
    print_report(figures)
    print(f"\nwritten to {options.out}")
    if options.history:
        write_history(figures)
        print(f"{__version__} is entered in {HISTORY}, drawn in {PICTURE}")


def parse_options() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("runs/bench.json"), help="file written (%(default)s)")
    parser.add_argument("--rounds", type=int, default=7, help="rounds of each comparison (%(default)s)")
    parser.add_argument("--seeds", type=int, default=4, help="runs logged per arena and strategy (%(default)s)")
    parser.add_argument("--clutter", type=int, default=10, help="random worlds logged, at most 10 (%(default)s)")
    families = f"in a world of each, bounce is logged: {', '.join(FAMILIES)} (all)"
    parser.add_argument("--families", type=_families, default=FAMILIES, metavar="NAME,...", help=families)
    parser.add_argument("--no-peers", action="store_true", help="measure this project alone")
    kept = f"leave {HISTORY.name} and its picture as they are"
    parser.add_argument("--no-history", dest="history", action="store_false", help=kept)
    return parser.parse_args()


def _families(text: str) -> tuple[str, ...]:
    """The families of worlds in a list A,B,C."""
    names = tuple(text.split(","))
    unknown = [name for name in names if name not in FAMILIES]
    if unknown:
        raise argparse.ArgumentTypeError(f"got {', '.join(unknown)}, expected some of {', '.join(FAMILIES)}")
    return names


def measured(states: list[Logged], options: argparse.Namespace) -> dict[str, Any]:
    """Every figure but those of the machine."""
    corridor = load_world("corridor")
    figures = alone(thinned(states, 300), options.rounds)
    figures["trial_realtime_factor"] = realtime_factor(corridor, 3 * options.rounds)
    figures["stages"] = stage_shares([state for state in states if state.chooses])
    figures["pruning_agreement"] = agreement(states)
    figures["rollouts"] = of_plans = rollouts(logged_calls(options.families), options.rounds)
    figures["plan_to_goal"] = of_plans.pop("plan_to_goal")
    figures["rollout_steps_per_second"] = of_plans.pop("steps_per_second")
    figures["trials_per_second"] = trials_per_second(corridor, 3 * options.rounds)
    figures["gym_steps_per_second"] = gym_steps_per_second(corridor, 3 * options.rounds)
    figures["protocol"] = protocol(options.rounds)
    figures["driver_cpu"] = driver_cpu()
    figures["skipped"] = dict.fromkeys(STEPS, "not asked for")
    if not options.no_peers:
        comparisons, figures["skipped"] = beside_peers(states, options.rounds)
        figures["ratios"] |= {name: each.pop("ratio") for name, each in comparisons.items()}
        figures["comparisons"] = comparisons
    return figures


def beside_peers(states: list[Logged], rounds: int) -> tuple[dict[str, Any], dict[str, str]]:
    """Every comparison by name, and the reason for each peer that had to be skipped."""
    corridor = load_world("corridor")
    inside = thinned([state for state in states if state.world.name == corridor.name], 200)
    choosing = thinned([state for state in states if state.chooses], 60)
    comparisons: dict[str, dict[str, Callable[[Peer], dict[str, Any]]]] = {
        "ir-sim": {
            "scan_vs_irsim": lambda peer: beside_irsim_scan(peer, corridor, inside, rounds),
            "trial_vs_irsim": lambda peer: beside_irsim_trial(peer, corridor, SCAN_PERIOD, rounds),
            "trial_vs_irsim_at_pose_rate": lambda peer: beside_irsim_trial(peer, corridor, POSE_PERIOD, rounds),
        },
        "dynamic-window-approach": {"cycle_vs_dwa": lambda peer: beside_dwa(peer, choosing, rounds)},
    }
    done: dict[str, Any] = {}
    skipped: dict[str, str] = {}
    for peer, each in comparisons.items():
        try:
            install(peer)
            with Peer() as running:
                done |= {name: compare(running) for name, compare in each.items()}
        except PeerError as error:
            skipped[peer] = str(error)
    return done, skipped


def thinned(states: list[Logged], most: int) -> list[Logged]:
    """At most `most` of the states, evenly spread."""
    return states[:: max(1, -(-len(states) // most))]


if __name__ == "__main__":
    main()
