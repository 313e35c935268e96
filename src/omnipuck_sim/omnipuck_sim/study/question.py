"""What a study asks: everything that decides its rows, and nothing else."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from collplan_core.strategies import STRATEGIES
from omnipuck_sim.study.errors import StudyError


@dataclass(frozen=True)
class Question:
    """By default the paper's 300 runs. Paper: IV-B, IV-C.

    Attributes:
        worlds: NAME, FILE (YAML or SDF), FAMILY:SEED, FAMILY:A-B, both inclusive, or barn:DIR.
        strategies: named weight sets.
        map_periods: T_map [s]; None is the paper's five for its strategies, the parameter's default for any other.
        trials: in each cell of the grid.
        seed: of the study.
        values: "KEY=VALUE" of any parameter; "KEY=A,B,C" makes an axis.
        start, goal: x, y [m]; None is each world's own.
        barn_scale: factor on the worlds of barn:DIR.
        ablations: whether every named ablation is run beside the grid as it is.
    """

    worlds: tuple[str, ...] = ("corridor",)
    strategies: tuple[str, ...] = tuple(STRATEGIES)
    map_periods: tuple[float, ...] | None = None
    trials: int = 20
    seed: int = 0
    values: tuple[str, ...] = ()
    start: tuple[float, ...] | None = None
    goal: tuple[float, ...] | None = None
    barn_scale: float = 1.0
    ablations: bool = False

    def __post_init__(self) -> None:
        for name, number, least in (("--trials", self.trials, 1), ("--seed", self.seed, 0)):
            if number < least:
                raise StudyError(f"{name}: got {number}, expected at least {least}")
        for name in ("worlds", "strategies", "map_periods"):
            if getattr(self, name) == ():
                raise StudyError(f"--{name.replace('_', '-')}: got none, the grid would be empty")

    def record(self) -> dict[str, Any]:
        """As JSON holds it."""
        return asdict(self)


def question_from(record: Mapping[str, Any]) -> Question:
    """The question that a record describes; raises TypeError where it describes none."""
    parts: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value for key, value in record.items()}
    return Question(**parts)
