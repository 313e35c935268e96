"""What each reading of the paper is worth: one at a time back to its printed form, over generated worlds (simulated).

    .venv/bin/python benchmarks/readings.py --seeds 1000 1050

prints a table: share of runs that reach the goal, mean arrival time (a run that does not arrive counts with the limit).
"""

import argparse
from collections.abc import Iterator

import numpy as np

from collplan_core.params import Settings
from collplan_core.strategies import STRATEGIES
from collplan_core.worlds import load_world
from omnipuck_sim.trial import REACHED, TrialResult, run_trial

CHANGES: dict[str, dict[str, object]] = {
    "as shipped": {},
    "J_pos as printed": {"planner.position_cost": "printed"},
    "angle of Alg. 1 as printed": {"planner.turn_angle": "printed"},
    "J_risk,g as printed": {"planner.gap_risk": "printed"},
    "no approach term, as printed": {"planner.approach_risk": "printed"},
    "shadow edges alone, as printed": {"planner.frontiers": "printed"},
    "speeds as printed": {"planner.speeds": "printed"},
    "time law as printed": {"planner.time_law": "printed"},
    "Alg. 3 as printed": {"controller.maneuver_rule": "printed"},
    "goal vector as unit vector": {"planner.goal_vector": "unit"},
    "waypoints on the chord": {"planner.waypoints": "chord"},
    "first of equal costs": {"planner.tie_rule": "first"},
    "without R_ref": {"planner.rebound_reward": False},
    "without (1 - J_risk,h)": {"planner.collision_factor": False},
    "without position pruning": {"planner.position_pruning": False},
    "without velocity pruning": {"planner.velocity_pruning": False},
}


def trials(settings: Settings, seeds: range) -> list[TrialResult]:
    """One run in each of the worlds random:SEED."""
    return [run_trial(load_world(f"random:{seed}"), settings, seed) for seed in seeds]


def cells(change: dict[str, object], seeds: range) -> Iterator[str]:
    """Reached, mean time and impacts a run, for each strategy."""
    for strategy in STRATEGIES:
        runs = trials(Settings().with_values({"planner.strategy": strategy, **change}), seeds)
        reached = sum(run.outcome == REACHED for run in runs)
        times, impacts = [run.arrival_time for run in runs], [len(run.impacts) for run in runs]
        yield f"{reached}/{len(runs)}, {np.mean(times):.2f} s, {np.mean(impacts):.2f}"


def main() -> None:
    """Prints the table as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", nargs=2, type=int, default=(1000, 1050), metavar=("FIRST", "END"))
    seeds = range(*parser.parse_args().seeds)
    print("| reading | " + " | ".join(STRATEGIES) + " |\n|" + "---|" * (len(STRATEGIES) + 1))
    for name, change in CHANGES.items():
        print(f"| {name} | " + " | ".join(cells(change, seeds)) + " |", flush=True)


if __name__ == "__main__":
    main()
