"""The question of a study: everything that decides its rows, and nothing else."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from collplan_core.parameters import Simulation, all_specs, unknown_key
from collplan_core.parameters.spec import Spec
from collplan_core.strategies import PAPER_WEIGHTS
from collplan_study.errors import StudyError
from collplan_study.question.specification import specification_of

OWN_OPTION = {
    "planner.strategy": "--strategies",
    "planner.map_period": "--map-periods",
    "simulator.engine": "--engine",
    "simulator.seed": "--seed",
    "simulator.world": "--worlds",
    "lidar.world": "--worlds",
}
"""Parameters that have an option of their own, which --set refuses."""


@dataclass(frozen=True)
class Question:
    """The question of a study; the defaults are the paper's 300 runs. Paper: IV-B, IV-C.

    Attributes:
        worlds: NAME, FILE, FAMILY:SEED, FAMILY:A-B, both inclusive, or DIR, a family of world files.
        strategies: named weight sets.
        map_periods: T_map [s]; None is the paper's five for its strategies, the parameter's default for any other.
        trials: number in each cell of the grid.
        seed: seed of the study, from which those of the trials follow.
        values: "KEY=VALUE" of any parameter; "KEY=A,B,C" makes an axis.
        start, goal: x, y [m]; None takes each world's own.
        ablations: whether every named ablation is run beside the main grid.
        ablation_strategies: strategies that the ablations are run with; None is all of them.
        ablation_trials: number in each cell of an ablation; None is `trials`.
        engine: simulator.engine, which computes the contacts.
        bounces: whether the question is what deliberate bounces gain, with variants and a report of its own.
    """

    worlds: tuple[str, ...] = ("corridor",)
    strategies: tuple[str, ...] = tuple(PAPER_WEIGHTS)
    map_periods: tuple[float, ...] | None = None
    trials: int = 20
    seed: int = 0
    values: tuple[str, ...] = ()
    start: tuple[float, ...] | None = None
    goal: tuple[float, ...] | None = None
    ablations: bool = False
    ablation_strategies: tuple[str, ...] | None = None
    ablation_trials: int | None = None
    engine: str = Simulation().engine
    bounces: bool = False

    def __post_init__(self) -> None:
        for name, least in (("trials", 1), ("ablation_trials", 1), ("seed", 0)):
            number = getattr(self, name)
            if number is not None and number < least:
                raise StudyError(f"{_option(name)}: got {number}, expected at least {least}")
        for name in ("worlds", "strategies", "map_periods", "ablation_strategies"):
            _check_once(_option(name), getattr(self, name))
        for strategy in self.ablation_strategies or () if self.ablations else ():
            if strategy not in self.strategies:
                expected = f"expected some of --strategies {','.join(self.strategies)}"
                raise StudyError(f"--ablation-strategies: got {strategy}, {expected}")
        if specification_of(self.bounces).compares:
            self._check_compared()

    def _check_compared(self) -> None:
        """Where strategies are compared there are neither axes nor several T_map."""
        several = [f"--set {text}" for text in self.values if "," in text]
        if len(self.map_periods or ()) > 1:
            several.append("--map-periods")
        if several:
            raise StudyError(f"{several[0]}: got several values, expected one beside --bounces")
        if len(self.strategies) < 2:
            raise StudyError("--strategies: got one, expected two or more to compare beside --bounces")

    def record(self) -> dict[str, Any]:
        """The question as JSON holds it."""
        return asdict(self)


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _check_once(option: str, values: Sequence[Any] | None) -> None:
    """Refuses a list that is empty or has a value twice."""
    if values == ():
        raise StudyError(f"{option}: got none, the grid would be empty")
    for value, count in Counter(values or ()).items():
        if count > 1:
            raise StudyError(f"{option}: got {value} {count} times, expected each value once")


def question_from(record: Mapping[str, Any]) -> Question:
    """The question of a record, as JSON holds it.

    Raises:
        TypeError: the record has keys that a question has not.
        StudyError: a value is out of range.
    """
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
