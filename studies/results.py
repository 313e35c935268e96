"""The command `make results`: the studies behind docs/results.md; it runs what is missing of them, one after another.

    make results                             # all of them
    make results ARGS="table_1 bounces"      # these alone
    make results ARGS="--barn DIR"           # and those in BARN's worlds, from the data set's folder

Each has a folder in runs/results. A study that is complete there is not run again; Ctrl-C ends in order, and the next
call goes on. Minutes are of two idle cores. Other tables have commands of their own: make optimum, graph-gain, rivals,
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
from collplan_study.question.ablations import ALL_PRINTED
from collplan_study.question.held_out import (
    ABLATION_WORLDS,
    FAMILIES,
    PAPER_WORLDS,
    PERIOD_WORLDS,
    STUDY_SEED,
    held_out_worlds,
)
from collplan_study.question.question import Question
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
IN_BARN = (
    *("--strategies", ",".join((*Question().strategies, *TIME_TO_GOAL)), *AT_ONE_PERIOD),
    *("--set", "trial.timeout=100", "--set"),
)
PRINTED = [option for key, value in ALL_PRINTED.items() for option in ("--set", f"{key}={str(value).lower()}")]

PARTS: Mapping[str, Part] = {
    "table_1_corridor": Part(2, _in_worlds("corridor", *AT_ONE_PERIOD, trials=500)),
    "table_1": Part(1, _in_worlds(PAPER_WORLDS, *AT_ONE_PERIOD)),
    "all_printed": Part(2, _in_worlds(PAPER_WORLDS, *AT_ONE_PERIOD, *PRINTED)),
    "set_e": Part(2, _in_worlds(PAPER_WORLDS, *AT_ONE_PERIOD, "--set", "local_map.predicted=printed")),
    "set_e_no_floor": Part(
        2,
        _in_worlds(
            PAPER_WORLDS,
            *AT_ONE_PERIOD,
            *("--set", "local_map.predicted=printed", "--set", "planner.time_floor=1e-9"),
        ),
    ),
    "map_periods_corridor": Part(2, _in_worlds("corridor", trials=100)),
    "map_periods": Part(3, _in_worlds(PERIOD_WORLDS)),
    "ablations": Part(12, ("--ablations", "--worlds", f"corridor,{ABLATION_WORLDS}")),
    "bounces": Part(14, ("--bounces", "--no-ablations")),
    "bounces_mujoco": Part(22, ("--bounces", "--no-ablations", "--engine", "mujoco")),
    "variants": Part(16, ("--bounces", *_in_worlds(VARIED, "--strategies", "bounce,avoid"))),
}
BARN: Mapping[str, Part] = {
    "barn": Part(20, (*_in_worlds(str(OUT / "barn_worlds")), *IN_BARN, "planner.goal_tolerance=1")),
    "barn_narrow": Part(
        20, (*_in_worlds(str(OUT / "barn_narrow_worlds")), *IN_BARN, f"planner.goal_tolerance={SCALE}")
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
