"""The command `make results`: runs the missing studies behind the tables of docs.

    make results                             # all of them
    make results ARGS="table_1 bounces"      # these alone
    make results ARGS="--barn DIR"           # and those in BARN's worlds, from the data set's folder

Each has a folder in runs/results. A study that is complete there is not run again; Ctrl-C ends in order, and the next
call goes on. Minutes are of two idle cores. Other tables have commands of their own: make optimum, graph-gain,
bench. Simulated.
"""

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import barn
from collplan_core.strategies import TIME_TO_GOAL
from collplan_study.main import main as study
from collplan_study.question.held_out import (
    ABLATION_WORLDS,
    FAMILIES,
    PAPER_WORLDS,
    PERIOD_WORLDS,
    STUDY_SEED,
    held_out_worlds,
)
from collplan_study.question.question import Question
from collplan_study.question.specification import SPREADS
from collplan_study.run.study_folder import PROVENANCE

OUT = Path("runs/results")
SCALE = "0.42"
"""Factor on BARN's lengths with which its worlds are as narrow for this robot as for the Jackal."""


class Part(NamedTuple):
    """A study: how long it takes on two idle cores [min], and its options beside --seed and --out."""

    minutes: float
    options: tuple[str, ...]


def _in_worlds(worlds: str, *options: str, trials: int = 1) -> tuple[str, ...]:
    return ("--worlds", worlds, "--trials", str(trials), *options)


AT_ONE_PERIOD = ("--map-periods", "0.2")
VARIED = ",".join(held_out_worlds(each, 12 if each in ("u", "serpentine") else 8) for each in (*FAMILIES, "serpentine"))
TWO = ("--strategies", "bounce,avoid")
SPREAD = [option for value in SPREADS for option in ("--set", value)]
BOTH_LIDARS = ("--set", "lidar.sensor=ideal,low_cost")
MOUNT = {"offset_x": 0.03, "offset_yaw": 0.1745}
"""Place of a LIDAR that is not in the middle, 3 cm ahead and turned by 10 degrees [m, rad]."""
MOUNTED = [
    option for key, value in MOUNT.items() for to in ("lidar", "scan") for option in ("--set", f"{to}.{key}={value}")
]
ARENAS = "corridor,l_corridor,slalom"
TURNS = f"{held_out_worlds('random')},{held_out_worlds('serpentine')},{held_out_worlds('u')}"
TIME_TO_GOAL_ALL = ("--strategies", ",".join(TIME_TO_GOAL), *SPREAD)
TWO_SPREAD = (*TWO, *SPREAD)
FOUR_FAMILIES = ",".join(f"{family}:300-307" for family in ("serpentine", "u", "baffles", "random"))
IN_BARN = (
    *("--strategies", ",".join((*Question().strategies, *TIME_TO_GOAL)), *AT_ONE_PERIOD),
    *("--set", "trial.timeout=100", "--set"),
)

PARTS: Mapping[str, Part] = {
    "table_1_corridor": Part(5, _in_worlds("corridor", *AT_ONE_PERIOD, trials=500)),
    "table_1": Part(2, _in_worlds(PAPER_WORLDS, *AT_ONE_PERIOD)),
    "set_e": Part(3, _in_worlds(PAPER_WORLDS, *AT_ONE_PERIOD, "--set", "local_map.predicted=printed")),
    "set_e_no_floor": Part(
        3,
        _in_worlds(
            PAPER_WORLDS,
            *AT_ONE_PERIOD,
            *("--set", "local_map.predicted=printed", "--set", "planner.time_floor=1e-9"),
        ),
    ),
    "map_periods_corridor": Part(6, _in_worlds("corridor", trials=100)),
    "map_periods": Part(6, _in_worlds(PERIOD_WORLDS)),
    "ablations": Part(16, ("--ablations", *_in_worlds(f"corridor,{ABLATION_WORLDS}", trials=2))),
    "bounces": Part(18, ("--bounces", "--no-ablations")),
    "bounces_mujoco": Part(8, ("--bounces", "--no-ablations", "--engine", "mujoco", *TWO, "--trials", "1")),
    "variants": Part(22, ("--bounces", *_in_worlds(VARIED, *TWO))),
    "lidar_arenas": Part(4, _in_worlds(ARENAS, *AT_ONE_PERIOD, trials=100)),
    "lidar_arenas_low_cost": Part(
        5, _in_worlds(ARENAS, *AT_ONE_PERIOD, "--set", "lidar.sensor=low_cost", *MOUNTED, trials=100)
    ),
    "lidar_paper": Part(4, _in_worlds(PERIOD_WORLDS, *AT_ONE_PERIOD, *BOTH_LIDARS)),
    "lidar_time_to_goal": Part(8, _in_worlds(TURNS, *TIME_TO_GOAL_ALL, *BOTH_LIDARS)),
    "range_noise": Part(
        3, _in_worlds("serpentine:300-311", *TWO_SPREAD, "--set", "lidar.range_noise=0,0.003,0.01", trials=2)
    ),
    "impact_speed": Part(
        3, _in_worlds(FOUR_FAMILIES, "--strategies", "bounce", *SPREAD, "--set", "limits.impact_speed=1.2,1,0.8,0.6")
    ),
}
BARN: Mapping[str, Part] = {
    "barn": Part(27, (*_in_worlds(str(OUT / "barn_worlds")), *IN_BARN, "planner.goal_tolerance=1")),
    "barn_narrow": Part(
        27, (*_in_worlds(str(OUT / "barn_narrow_worlds")), *IN_BARN, f"planner.goal_tolerance={SCALE}")
    ),
}
"""In the 260 worlds of the data set on which nothing was tuned."""


def main(args: Sequence[str] | None = None) -> int:
    """Runs the studies asked for, or what is missing of them; the exit code is that of the first that fails."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join((*PARTS, *BARN))} (default all)")
    parser.add_argument("--barn", type=Path, metavar="DIR", help="folder of the BARN data set")
    given = parser.parse_args(args)
    known = PARTS if given.barn is None else {**PARTS, **BARN}
    unknown = [name for name in given.parts if name not in known]
    if unknown:
        parser.error(f"got {', '.join(unknown)}, expected some of {', '.join(known)}; BARN's need --barn DIR")
    asked = {name: known[name] for name in given.parts or known}
    print(f"{len(asked)} studies, about {sum(part.minutes for part in asked.values()):g} minutes", flush=True)
    for name, part in asked.items():
        code = _complete(name, part, given.barn)
        if code:
            return code
    return 0


def _complete(name: str, part: Part, data: Path | None) -> int:
    folder = OUT / name
    print(f"{name}: about {part.minutes:g} minutes, in {folder}", flush=True)
    if (folder / PROVENANCE).exists():
        return study(["--resume", str(folder)])
    if name in BARN and (code := _write_worlds(name, data)):
        return code
    return study([*part.options, "--seed", str(STUDY_SEED), "--out", str(folder)])


def _write_worlds(name: str, data: Path | None) -> int:
    scale = SCALE if name == "barn_narrow" else "1"
    return barn.main(["worlds", str(data), "--held-out", "--scale", scale, "--out", str(OUT / f"{name}_worlds")])


if __name__ == "__main__":
    sys.exit(main())
