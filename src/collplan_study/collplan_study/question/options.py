"""The command line of the study, and the question it asks."""

import argparse
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from collplan_core.command_line import parser_of
from collplan_core.parameters import all_specs
from collplan_study.errors import StudyError
from collplan_study.question.grid import Task
from collplan_study.question.question import Question, question_from
from collplan_study.question.specification import BOUNCES, PAPER, specification_of

ALL, MAIN, ABLATIONS, NONE = "all", "main", "ablations", "none"


@dataclass(frozen=True)
class StudyOptions:
    """A parsed command line.

    Attributes:
        overrides: parts of the question that the command line gives.
        jobs: number of processes.
        resume: folder of a study to complete.
        out: folder of a new study; None is runs/study-<time>.
        dask: address of a Dask scheduler; None runs the trials here.
        report: whether report and figures are written.
        run: which of the missing trials are run: ALL, those of the MAIN grid, those of the ABLATIONS, or NONE.
    """

    overrides: dict[str, Any] = field(default_factory=dict)
    jobs: int = 1
    resume: Path | None = None
    out: Path | None = None
    dask: str | None = None
    report: bool = True
    run: str = ALL

    def question(self, recorded: Question | None = None) -> Question:
        """The question of a new study, or of one that is resumed.

        Args:
            recorded: question of the study that is resumed; None starts a new one.

        Raises:
            StudyError: the command line contradicts the recorded question, or asks for something impossible.
        """
        if recorded is None:
            return question_from(self._overridden(self._defaults()))
        asked = question_from(self._overridden(recorded.record()))
        for part in fields(Question):
            before, now = getattr(recorded, part.name), getattr(asked, part.name)
            if before != now:
                raise StudyError(f"--resume {self.resume}: another study, its {part.name} is {before!r}, got {now!r}")
        return recorded

    def selects(self, task: Task) -> bool:
        """Returns whether `run` includes a trial."""
        return self.run in (ALL, ABLATIONS if task.labels["ablation"] else MAIN)

    def _defaults(self) -> Mapping[str, Any]:
        specification = specification_of(bool(self.overrides.get("bounces")))
        return specification.with_ablations if self.overrides.get("ablations") else specification.defaults

    def _overridden(self, parts: Mapping[str, Any]) -> dict[str, Any]:
        """Parts of a question with the overrides of the command line; --set replaces only the parameters it names."""
        values = self.overrides.get("values", ())
        named = {text.partition("=")[0] for text in values}
        kept = [text for text in parts.get("values", ()) if text.partition("=")[0] not in named]
        return {**parts, **self.overrides, "values": (*kept, *values)}


DESCRIPTION = """\
Runs a grid of simulated trials: worlds x strategies x mapping periods x --set axes x trials; by default the paper's
300 runs. A trial's noise depends on world, trial number and --seed alone, so that strategies meet the same noise.

Every row is written when its trial ends: after a stop of any kind, --resume DIR completes the study.
The request is fulfilled: exit code 0. Workers or disk were lost, or a trial ended in an error: 1. The request cannot be
fulfilled: 2. Ctrl-C: 130.
"""
EPILOG = """\
examples:
  study                                                     the paper's evaluation
  study --worlds random:0-99 --map-periods 0.2 --trials 4   worlds not used for tuning
  study --set robot.max_acceleration=1,1.5,3                one more axis
  study --bounces --worlds u:0-7 --seed 1                   gain by deliberate bounces, in few worlds
  study --bounces --engine mujoco --out runs/mujoco         the same with a compliant ring
  study --resume runs/study-2026-01-31_12-00-00             the trials missing there
  study --resume runs/study-2026-01-31_12-00-00 --run none  tables and report of the trials done
"""


def _parser() -> argparse.ArgumentParser:
    parser = parser_of("study", DESCRIPTION, EPILOG)
    _add_question(parser.add_argument_group("the grid"))
    add = parser.add_argument_group("how it is run").add_argument
    cpus = len(os.sched_getaffinity(0))
    add("--jobs", type=int, default=cpus, metavar="N", help=f"processes (default {cpus}, the CPUs here)")
    add("--dask", metavar="ADDRESS", help="run on the Dask cluster with this scheduler instead")
    add("--out", type=Path, metavar="DIR", help="folder of this study, new or empty (default runs/study-<time>)")
    add("--resume", type=Path, metavar="DIR", help="complete the study in DIR; its grid is recorded there")
    parts = "the main grid or its ablations alone, or none: tables and report of the trials done"
    add("--run", choices=(ALL, MAIN, ABLATIONS, NONE), default=ALL, help=f"the part to run (default {ALL}): {parts}")
    add("--no-report", dest="report", action="store_false", help="leave out report and figures, make the tables alone")
    return parser


def _names(text: str) -> tuple[str, ...]:
    """The items of a list on the command line, A,B,C."""
    items = tuple(text.split(","))
    if not all(items):
        raise argparse.ArgumentTypeError(f"got {text!r}, expected a list A,B,C without gaps")
    return items


def _numbers(text: str) -> tuple[float, ...]:
    """The numbers of a list on the command line, A,B,C."""
    try:
        return tuple(float(item) for item in _names(text))
    except ValueError:
        raise argparse.ArgumentTypeError(f"got {text!r}, expected numbers A,B,C") from None


def _add_question(group: argparse._ArgumentGroup) -> None:
    default = Question()

    def add(*names: str, help: str, **kwargs: Any) -> None:
        group.add_argument(*names, help=help, default=argparse.SUPPRESS, **kwargs)

    worlds = "NAME, FILE, FAMILY:SEED, FAMILY:A-B, both inclusive, or DIR, a family of world files"
    add("--worlds", type=_names, metavar="W,...", help=f"{worlds} (default {','.join(default.worlds)})")
    add(
        "--strategies", type=_names, metavar="S,...", help=f"named weight sets (default {','.join(default.strategies)})"
    )
    periods = "default 0.2,0.4,0.6,0.8,1.0 for the paper's strategies, their own for others"
    add("--map-periods", type=_numbers, metavar="T,...", help=f"T_map [s] ({periods})")
    add("--trials", type=int, metavar="N", help=f"trials in each cell of the grid (default {default.trials})")
    add("--seed", type=int, metavar="N", help=f"seed of the study (default {default.seed})")
    changes = "change a parameter; several values make an axis; may be given several times"
    add("--set", dest="values", action="append", metavar="KEY=VALUE,...", help=changes)
    add("--start", type=float, nargs=2, metavar=("X", "Y"), help="start position [m] (default each world's own)")
    add("--goal", type=float, nargs=2, metavar=("X", "Y"), help="goal position [m] (default each world's own)")
    add("--engine", metavar="NAME", help=f"engine that computes contacts: {_engines()} (default {default.engine})")
    add(
        "--ablations", action="store_true", help=f"run each named ablation too ({_defaults_text(PAPER.with_ablations)})"
    )
    add("--no-ablations", dest="ablations", action="store_false", help="leave them out beside --bounces")
    add(
        "--ablation-strategies",
        type=_names,
        metavar="S,...",
        help="those that the ablations are run with (default all)",
    )
    add("--ablation-trials", type=int, metavar="N", help="trials in each cell of an ablation (default as without)")
    held_out = "measure the gain by deliberate bounces, in worlds not used for tuning"
    add("--bounces", action="store_true", help=f"{held_out} ({_defaults_text(BOUNCES.defaults)})")


def _engines() -> str:
    return " or ".join(all_specs()["simulator.engine"].choices)


def _defaults_text(question: Mapping[str, Any]) -> str:
    """Help text: the defaults with an option that stands for a question."""
    named = {{"values": "set"}.get(key, key): value for key, value in question.items() if key != "ablations"}
    shown = {key: ",".join(map(str, value)) if isinstance(value, tuple) else value for key, value in named.items()}
    return "then the defaults are " + ", ".join(f"{key.replace('_', '-')} {value}" for key, value in shown.items())


def parse(args: Sequence[str] | None = None) -> StudyOptions:
    """Parses a command line.

    Args:
        args: without the program's name; None takes sys.argv's.

    Raises:
        StudyError: options that exclude each other or are out of range.
    """
    parsed = vars(_parser().parse_args(args))
    how = {part.name: parsed.pop(part.name) for part in fields(StudyOptions) if part.name != "overrides"}
    if how["jobs"] < 1:
        raise StudyError(f"--jobs: got {how['jobs']}, expected at least 1")
    if how["resume"] is not None and how["out"] is not None:
        raise StudyError("--out: a study that is resumed stays in its folder, leave it out")
    return StudyOptions(overrides=parsed, **how)
