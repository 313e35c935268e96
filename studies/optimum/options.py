"""The command line of `optimum`: which study is compared with the optimum."""

import argparse
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

from collplan_study.errors import StudyError
from collplan_study.question.held_out import TRIALS
from collplan_study.question.question import parse as parse_study
from collplan_study.run.study_folder import RUNS

FAMILIES = ("serpentine", "u", "baffles", "z", "l")
"""Families compared with the optimum without contact: their worlds are one corridor with right-angled turns."""
WORLDS, STUDY_SEED = "22000-22023", 64
"""Seeds of their held-out worlds, and the seed of the study in them: `collplan_study.question.held_out`."""

STUDY = (
    "--bounces",
    "--no-ablations",
    "--strategies=bounce,avoid",
    f"--worlds={','.join(f'{family}:{WORLDS}' for family in FAMILIES)}",
    f"--trials={TRIALS}",
    f"--seed={STUDY_SEED}",
)
"""Options of the study, where the command line does not say otherwise."""
DESCRIPTION = f"""\
How far are strategies from the best trajectory of a disc that must not touch anything and knows the map? Runs a study,
computes that trajectory in each of its worlds, and prints the ratio of the arrival times, a lower bound of it beside.
Leaves runs/optimum.json, and optimum.csv in the study's folder. Options that are not below are those of study:

  study {shlex.join(STUDY)}

Families: {", ".join(FAMILIES)}; worlds of others are left out. Needs CasADi. Every world has its trajectory:
exit code 0. One has none, or workers were lost: 1. Something asked for cannot be done: 2. Ctrl-C: 130.
"""
EPILOG = """\
examples:
  make optimum ARGS="--worlds u:0-3 --trials 1 --seed 1"   smaller, and for trying things
  make optimum ARGS="--of runs/bounces"                    the runs of a study that is there
"""


@dataclass(frozen=True)
class Options:
    """A parsed command line."""

    folder: Path  # folder of the study
    study: tuple[str, ...] | None  # command line of the study that is run first; None where its runs are there
    jobs: int  # number of processes


def parse(args: Sequence[str] | None = None) -> Options:
    """Parses a command line, without the program's name; None takes sys.argv's.

    Raises:
        StudyError: options that exclude each other or are out of range.
    """
    known, rest = _parser().parse_known_args(args)
    asked = parse_study(rest)
    if known.of is not None:
        if asked != replace(parse_study([]), jobs=asked.jobs):
            raise StudyError(f"--of {known.of}: its runs are there, expected no option of study but --jobs")
        return Options(known.of, None, asked.jobs)
    if asked.resume is not None:
        return Options(asked.resume, tuple(rest), asked.jobs)
    folder = asked.out or RUNS / f"optimum-{datetime.now():%Y-%m-%d_%H-%M-%S}"
    return Options(folder, (*STUDY, *rest, "--out", str(folder)), asked.jobs)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="make optimum",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--of", type=Path, metavar="DIR", help="folder of a study made with --bounces: run nothing")
    return parser
