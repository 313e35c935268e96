"""The question of a study, everything that decides its rows, and the command line that asks it."""

import argparse
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

from collplan_core.command_line import parser_of
from collplan_core.parameters import Simulation, all_specs, unknown_key
from collplan_core.parameters.spec import Spec
from collplan_core.strategies import PAPER_WEIGHTS
from collplan_study.errors import StudyError
from collplan_study.question.specification import BOUNCES, PAPER, Specification

OWN_OPTION = {
    "planner.strategy": "--strategies",
    "planner.map_period": "--map-periods",
    "simulator.engine": "--engine",
    "simulator.seed": "--seed",
    "simulator.world": "--worlds",
    "lidar.world": "--worlds",
}
"""Parameters that have an option of their own, which --set refuses."""


def option(flag: str, default: Any, help: str, **kwargs: Any) -> Any:
    """A field that an option of the command line sets: its meaning is the help of the option."""
    return field(default=default, metadata={"flag": flag, "help": help, **kwargs})


def _numbers(text: str) -> tuple[float, ...]:
    return tuple(map(float, text.split(",")))


def _shown(parts: Mapping[str, Any]) -> str:
    """Help text: the defaults with an option that stands for a question."""
    texts = {key: ",".join(map(str, value)) if isinstance(value, tuple) else value for key, value in parts.items()}
    return "then the defaults are " + ", ".join(f"{key.replace('_', '-')} {text}" for key, text in texts.items())


_WORLDS = "NAME, FILE, FAMILY:SEED, FAMILY:A-B, both inclusive, or DIR, a family of world files (default corridor)"
_STRATEGIES = f"named weight sets (default {','.join(PAPER_WEIGHTS)})"
_PERIODS = "T_map [s] (default 0.2,0.4,0.6,0.8,1.0 for the paper's strategies, their own for others)"
_CHANGES = "change a parameter; several values make an axis; may be given several times"
_ENGINES = f"engine that computes contacts: {' or '.join(all_specs()['simulator.engine'].choices)} (default pymunk)"
_ABLATIONS = f"run each named ablation too ({_shown(PAPER.with_ablations)})"
_BOUNCES = f"measure the gain by deliberate bounces, in worlds not used for tuning ({_shown(BOUNCES.defaults)})"
_VARIED, _FEWER = "those to run ablations with (default all)", "trials in each of their cells (default as without)"
_NAMES: dict[str, Any] = {"type": lambda text: tuple(text.split(",")), "metavar": "A,..."}
_NUMBER: dict[str, Any] = {"type": int, "metavar": "N"}
_POSITION: dict[str, Any] = {"type": float, "nargs": 2, "metavar": ("X", "Y")}


@dataclass(frozen=True)
class Question:
    """The question of a study; the defaults are the paper's 300 runs. Paper: IV-B, IV-C."""

    worlds: tuple[str, ...] = option("--worlds", ("corridor",), _WORLDS, **_NAMES)
    strategies: tuple[str, ...] = option("--strategies", tuple(PAPER_WEIGHTS), _STRATEGIES, **_NAMES)
    map_periods: tuple[float, ...] | None = option("--map-periods", None, _PERIODS, type=_numbers, metavar="T,...")
    trials: int = option("--trials", 20, "trials in each cell of the grid (default 20)", **_NUMBER)
    seed: int = option("--seed", 0, "seed of the study, from which those of the trials follow (default 0)", **_NUMBER)
    values: tuple[str, ...] = option("--set", (), _CHANGES, action="append", metavar="KEY=VALUE,...")
    start: tuple[float, ...] | None = option("--start", None, "start [m] (default each world's own)", **_POSITION)
    goal: tuple[float, ...] | None = option("--goal", None, "goal [m] (default each world's own)", **_POSITION)
    ablations: bool = option("--ablations", False, _ABLATIONS, action="store_true")
    ablation_strategies: tuple[str, ...] | None = option("--ablation-strategies", None, _VARIED, **_NAMES)
    ablation_trials: int | None = option("--ablation-trials", None, _FEWER, **_NUMBER)
    engine: str = option("--engine", Simulation().engine, _ENGINES, metavar="NAME")
    bounces: bool = option("--bounces", False, _BOUNCES, action="store_true")

    @property
    def specification(self) -> Specification:
        """What tells its question from the other."""
        return BOUNCES if self.bounces else PAPER

    def __post_init__(self) -> None:
        flags = {part.name: part.metadata["flag"] for part in fields(self)}
        for name, least in (("trials", 1), ("ablation_trials", 1), ("seed", 0)):
            number = getattr(self, name)
            if number is not None and number < least:
                raise StudyError(f"{flags[name]}: got {number}, expected at least {least}")
        for name in ("worlds", "strategies", "map_periods", "ablation_strategies"):
            _check_once(flags[name], getattr(self, name))
        for strategy in self.ablation_strategies or () if self.ablations else ():
            if strategy not in self.strategies:
                expected = f"expected some of --strategies {','.join(self.strategies)}"
                raise StudyError(f"--ablation-strategies: got {strategy}, {expected}")
        if self.bounces:
            several = [f"--set {text}" for text in self.values if "," in text]
            if several or len(self.map_periods or ()) > 1:
                option = (*several, "--map-periods")[0]
                raise StudyError(f"{option}: got several values, expected one beside --bounces")
            if len(self.strategies) < 2:
                raise StudyError("--strategies: got one, expected two or more to compare beside --bounces")


def _check_once(option: str, values: Sequence[Any] | None) -> None:
    if values == ():
        raise StudyError(f"{option}: got none, the grid would be empty")
    for value, count in Counter(values or ()).items():
        if count > 1:
            raise StudyError(f"{option}: got {value} {count} times, expected each value once")


def question_from(record: Mapping[str, Any]) -> Question:
    """The question of a record, as JSON holds it; a TypeError where it has keys that a question has not."""
    parts: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value for key, value in record.items()}
    return Question(**parts)


def parse_axes(texts: Sequence[str]) -> dict[str, tuple[Any, ...]]:
    """Axes of the grid as --set gives them: values by parameter key, parsed from texts KEY=A,B,C and checked.

    Raises:
        StudyError: a text not of this form, a key or a value given twice, or a key that has an option of its own.
        ParameterError: an unknown key, or a value out of its range.
    """
    axes: dict[str, tuple[Any, ...]] = {}
    for text in texts:
        key, equals, values = text.partition("=")
        if not equals:
            raise StudyError(f"--set: got {text!r}, expected KEY=VALUE or KEY=A,B,C")
        if key in OWN_OPTION:
            raise StudyError(f"--set {key}: has an option of its own, expected {OWN_OPTION[key]}")
        if key not in all_specs():
            raise unknown_key(key)
        if key in axes:
            raise StudyError(f"--set {key}: given twice, expected one list {key}=A,B,C")
        spec = all_specs()[key]
        axes[key] = tuple(spec.checked(_converted(spec, item)) for item in values.split(","))
        _check_once(f"--set {key}", axes[key])
    return axes


def _converted(spec: Spec, text: str) -> Any:
    """The text converted to the parameter's type; the text itself where it cannot be, which the check then refuses."""
    kind = type(spec.default)
    try:
        return {"true": True, "false": False}[text] if kind is bool else kind(text)
    except (KeyError, ValueError):
        return text


PARTS = {"all": (False, True), "main": (False,), "ablations": (True,), "none": ()}
"""Parts of the grid that `--run` names: whether they are the ablations."""
CPUS = len(os.sched_getaffinity(0))
_RUN = "the main grid or its ablations alone, or none: tables and report of the trials done (default all)"
_OUT = "folder of this study, new or empty (default runs/study-<time>)"
_RESUME = "complete the study in DIR; its grid is recorded there"
_FOLDER: dict[str, Any] = {"type": Path, "metavar": "DIR"}


@dataclass(frozen=True)
class StudyOptions:
    """A parsed command line."""

    overrides: dict[str, Any] = field(default_factory=dict)
    """Parts of the question that the command line gives."""
    jobs: int = option("--jobs", CPUS, f"processes (default {CPUS}, the CPUs here)", type=int, metavar="N")
    dask: str | None = option("--dask", None, "run on the Dask cluster with this scheduler instead", metavar="ADDRESS")
    out: Path | None = field(default=None, metadata={"flag": "--out", "help": _OUT, **_FOLDER})
    resume: Path | None = field(default=None, metadata={"flag": "--resume", "help": _RESUME, **_FOLDER})
    run: str = option("--run", "all", _RUN, choices=tuple(PARTS))
    report: bool = option("--no-report", True, "make the tables alone, no report or figures", action="store_false")

    def question(self, recorded: Question | None = None) -> Question:
        """The question of a new study, or that of the recorded one, which the command line must not contradict."""
        if recorded is None:
            specification = BOUNCES if self.overrides.get("bounces") else PAPER
            asked = specification.with_ablations if self.overrides.get("ablations") else specification.defaults
            return question_from(self._overridden(asked))
        before = asdict(recorded)
        for part, now in asdict(question_from(self._overridden(before))).items():
            if before[part] != now:
                raise StudyError(f"--resume {self.resume}: another study, its {part} is {before[part]!r}, got {now!r}")
        return recorded

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
  study --resume runs/study-2026-01-31_12-00-00 --run none  tables and report of the trials done
"""


def parse(args: Sequence[str] | None = None) -> StudyOptions:
    """Parses a command line, by default that of the process."""
    parser = parser_of("study", DESCRIPTION, EPILOG)
    grid, how = parser.add_argument_group("the grid"), parser.add_argument_group("how it is run")
    for group, parts in ((grid, fields(Question)), (how, fields(StudyOptions))):
        for part, asked in ((part, dict(part.metadata)) for part in parts if part.metadata):
            group.add_argument(asked.pop("flag"), dest=part.name, default=argparse.SUPPRESS, **asked)
    why = "leave them out beside --bounces"
    grid.add_argument("--no-ablations", dest="ablations", action="store_false", default=argparse.SUPPRESS, help=why)
    given = vars(parser.parse_args(args))
    overrides = {part.name: given.pop(part.name) for part in fields(Question) if part.name in given}
    options = StudyOptions(overrides, **given)
    if options.jobs < 1:
        raise StudyError(f"--jobs: got {options.jobs}, expected at least 1")
    if options.resume is not None and options.out is not None:
        raise StudyError("--out: a study that is resumed stays in its folder, leave it out")
    return options
