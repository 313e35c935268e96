"""The grid: every trial of a study, in the order of its table."""

from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, product
from typing import Any

from collplan_core.parameters import Settings
from collplan_core.strategies import PAPER_WEIGHTS, map_period_of
from collplan_core.worlds import World, WorldError, check_route
from collplan_study.errors import StudyError
from collplan_study.question.axes import parse_axes
from collplan_study.question.question import Question
from collplan_study.question.seeds import trial_seed
from collplan_study.question.sources import Source

PAPER_MAP_PERIODS = (0.2, 0.4, 0.6, 0.8, 1.0)
"""Paper: IV-C [s]."""

NO_ABLATION: Mapping[str, Mapping[str, Any]] = {"": {}}


@dataclass(frozen=True, eq=False)
class Task:
    """One trial: place in the table, what its row says of it before it is run, and what to run."""

    index: int
    labels: Mapping[str, Any]
    world: World
    settings: Settings
    seed: int


@dataclass(frozen=True, eq=False)
class Cell:
    """What the trials of one cell share, and how many there are."""

    source: Source
    labels: Mapping[str, Any]
    settings: Settings
    trials: int


@dataclass(frozen=True, eq=False)
class Grid:
    """Cells in the order of the table, and in each the trials 0, 1, ...

    Attributes:
        axes: keys of the parameters that have a column of their own.
    """

    cells: tuple[Cell, ...]
    axes: tuple[str, ...]
    seed: int

    @cached_property
    def _starts(self) -> list[int]:
        return list(accumulate((cell.trials for cell in self.cells), initial=0))

    def __len__(self) -> int:
        return self._starts[-1]

    def __iter__(self) -> Iterator[Task]:
        return (self.task(index) for index in range(len(self)))

    def task(self, index: int) -> Task:
        """The trial at a place of the table."""
        number = bisect_right(self._starts, index) - 1
        cell, trial = self.cells[number], index - self._starts[number]
        seed = trial_seed(self.seed, cell.source.world.name, trial)
        return Task(index, {**cell.labels, "trial": trial, "seed": seed}, cell.source.world, cell.settings, seed)


def make_grid(
    question: Question, sources: Sequence[Source], ablations: Mapping[str, Mapping[str, Any]] = NO_ABLATION
) -> Grid:
    """The grid of a question over its worlds.

    Args:
        question: what is asked; its worlds are `sources`.
        sources: the worlds.
        ablations: by name the parameters that each changes; they outrank the axes. "" is none.

    Raises:
        StudyError: nothing in the grid, or something twice.
        ParameterError: an unknown parameter or a value that does not fit.
        WorldError: a world without a route from start to goal for the robot.
    """
    _check_choices(question)
    axes = parse_axes(question.values)
    points = [dict(zip(axes, values, strict=True)) for values in product(*axes.values())]
    cells = tuple(
        _cell(source, name, changes, run, point, _trials(question, name))
        for name, changes in ablations.items()
        for source, run, point in product(sources, _runs(question, name), points)
    )
    if not cells:
        raise StudyError("the grid is empty: expected at least one world")
    _check_routes(cells)
    return Grid(cells, tuple(axes), question.seed)


def _runs(question: Question, ablation: str) -> list[tuple[str, float]]:
    """The strategies of an ablation, each with its T_map [s]."""
    chosen = question.ablation_strategies if ablation else None
    return [
        (strategy, period)
        for strategy in chosen or question.strategies
        for period in question.map_periods or _periods(question, strategy)
    ]


def _trials(question: Question, ablation: str) -> int:
    chosen = question.ablation_trials if ablation else None
    return chosen or question.trials


def _periods(question: Question, strategy: str) -> Sequence[float]:
    if strategy in PAPER_WEIGHTS and not question.bounces:
        return PAPER_MAP_PERIODS
    return (map_period_of(Settings().with_values({"planner.strategy": strategy})),)


def _check_choices(question: Question) -> None:
    _check_once("--strategies", question.strategies)
    _check_once("--ablation-strategies", question.ablation_strategies or ())
    _check_once("--map-periods", question.map_periods or ())


def _check_once(option: str, values: Sequence[Any]) -> None:
    for value, count in Counter(values).items():
        if count > 1:
            raise StudyError(f"{option}: got {value} {count} times, expected each value once")


def _cell(
    source: Source,
    ablation: str,
    changes: Mapping[str, Any],
    run: tuple[str, float],
    point: Mapping[str, Any],
    trials: int,
) -> Cell:
    strategy, period = run
    values = {**source.values, **point, "planner.strategy": strategy, "planner.map_period": period, **changes}
    settings = Settings().with_values(values)
    known = settings.values()
    labels = {
        "world": source.world.name, "family": source.family, "ablation": ablation, "strategy": strategy,
        "map_period_s": period, **{key: known[key] for key in point},
    }  # fmt: skip
    return Cell(source, labels, settings, trials)


def _check_routes(cells: Sequence[Cell]) -> None:
    """Each world once for each size of robot."""
    for world, radius in dict.fromkeys((cell.source.world, cell.settings.robot.radius) for cell in cells):
        for key, point in (("start", world.start), ("goal", world.goal)):
            if point is None:
                raise WorldError(f"{world.name}: {key}: missing, expected one in the world or --{key} X Y")
        check_route(world, world.start, world.goal, radius)  # type: ignore[arg-type]
