"""The grid of a study: every trial, in the order of its tables."""

from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, product
from typing import Any

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.planners import first_memory, map_period_of
from collplan_core.strategies import PAPER_WEIGHTS
from collplan_core.worlds import World, WorldError, check_route
from collplan_study.errors import StudyError
from collplan_study.question.axes import parse_axes
from collplan_study.question.question import Question
from collplan_study.question.seeds import trial_seed
from collplan_study.question.sources import Source

STRATEGY, MAP_PERIOD, ENGINE = "planner.strategy", "planner.map_period", "simulator.engine"

PAPER_MAP_PERIODS: Mapping[str, tuple[float, ...]] = dict.fromkeys(PAPER_WEIGHTS, (0.2, 0.4, 0.6, 0.8, 1.0))
"""T_map [s] at which the paper evaluates its strategies, by name. Paper: IV-C."""

NO_ABLATION: Mapping[str, Mapping[str, Any]] = {"": {}}
"""Ablations of a grid that has none: the empty name, which changes nothing."""


@dataclass(frozen=True, eq=False)
class Task:
    """One trial to be run.

    Attributes:
        index: its place in the grid.
        labels: columns of its row that are known before it is run.
        world, settings, seed: arguments of the trial.
    """

    index: int
    labels: Mapping[str, Any]
    world: World
    settings: Settings
    seed: int


@dataclass(frozen=True, eq=False)
class CellSpec:
    """A cell of the grid: trials that differ in their seed alone.

    Attributes:
        source: the world.
        labels: columns of their rows that the trials share.
        settings: the trials' parameters.
        trials: how many.
    """

    source: Source
    labels: Mapping[str, Any]
    settings: Settings
    trials: int


@dataclass(frozen=True, eq=False)
class TrialGrid:
    """All trials of a study: the cells in order, and in each cell the trials 0, 1, ...

    Attributes:
        cells: in the order of the tables.
        axes: keys of the --set parameters, which have columns of their own.
        seed: seed of the study.
    """

    cells: tuple[CellSpec, ...]
    axes: tuple[str, ...]
    seed: int

    @cached_property
    def _first_indices(self) -> list[int]:
        return list(accumulate((cell.trials for cell in self.cells), initial=0))

    def __len__(self) -> int:
        return self._first_indices[-1]

    def __iter__(self) -> Iterator[Task]:
        return (self.task(index) for index in range(len(self)))

    def task(self, index: int) -> Task:
        """The trial at a place of the grid."""
        number = bisect_right(self._first_indices, index) - 1
        cell, trial = self.cells[number], index - self._first_indices[number]
        seed = trial_seed(self.seed, cell.source.world.name, trial)
        return Task(index, {**cell.labels, "trial": trial, "seed": seed}, cell.source.world, cell.settings, seed)


def make_grid(
    question: Question, sources: Sequence[Source], ablations: Mapping[str, Mapping[str, Any]] = NO_ABLATION
) -> TrialGrid:
    """The grid of a question over its worlds.

    Args:
        question: what is asked; its worlds are `sources`.
        sources: the worlds.
        ablations: changed parameters by name of the ablation; they override the axes. The empty name changes nothing.

    Raises:
        StudyError: the grid is empty, or a value is given twice.
        ParameterError: an unknown parameter or a value out of its range.
        WorldError: a world without a route from start to goal for the robot.
    """
    _check_choices(question)
    axes = parse_axes(question.values)
    points = [dict(zip(axes, values, strict=True)) for values in product(*axes.values())]
    cells = tuple(
        _cell_spec(source, name, changes, {**point, **strategy, ENGINE: question.engine}, _trials(question, name))
        for name, changes in ablations.items()
        for source, strategy, point in product(sources, _strategies(question, name), points)
    )
    if not cells:
        raise StudyError("the grid is empty: expected at least one world")
    _check_routes(cells)
    return TrialGrid(cells, tuple(axes), question.seed)


def _strategies(question: Question, ablation: str) -> list[dict[str, Any]]:
    """The parameters of every strategy and T_map that an ablation is run with."""
    chosen = question.ablation_strategies if ablation else None
    return [
        {STRATEGY: strategy, MAP_PERIOD: period}
        for strategy in chosen or question.strategies
        for period in question.map_periods or _periods(question, strategy)
    ]


def _trials(question: Question, ablation: str) -> int:
    chosen = question.ablation_trials if ablation else None
    return chosen or question.trials


def _periods(question: Question, strategy: str) -> Sequence[float]:
    """T_map [s] where the question names none: those of the paper's evaluation, else the strategy's own."""
    evaluated = {} if question.bounces else PAPER_MAP_PERIODS
    return evaluated.get(strategy) or (map_period_of(Settings().with_values({STRATEGY: strategy})),)


def _check_choices(question: Question) -> None:
    _check_once("--strategies", question.strategies)
    _check_once("--ablation-strategies", question.ablation_strategies or ())
    _check_once("--map-periods", question.map_periods or ())


def _check_once(option: str, values: Sequence[Any]) -> None:
    for value, count in Counter(values).items():
        if count > 1:
            raise StudyError(f"{option}: got {value} {count} times, expected each value once")


def _cell_spec(
    source: Source, ablation: str, changes: Mapping[str, Any], point: Mapping[str, Any], trials: int
) -> CellSpec:
    """A cell: axes, strategy and engine of `point`, and over them the ablation's changes."""
    settings = Settings().with_values({**point, **changes})
    first_memory(settings, source.world)  # refused before the first trial
    known = settings.values()
    labels = {
        "world": source.world.name,
        "family": source.family,
        "ablation": ablation,
        "engine": point[ENGINE],
        "strategy": point[STRATEGY],
        "map_period_s": point[MAP_PERIOD],
        **{key: known[key] for key in point if key not in (STRATEGY, MAP_PERIOD, ENGINE)},
    }
    return CellSpec(source, labels, settings, trials)


def _check_routes(cells: Sequence[CellSpec]) -> None:
    """Check start, goal and route in each world, once for each size of robot."""
    for world, radius in dict.fromkeys((cell.source.world, cell.settings.robot.radius) for cell in cells):
        check_route(world, _end(world, "start", world.start), _end(world, "goal", world.goal), radius)


def _end(world: World, key: str, point: np.ndarray | None) -> np.ndarray:
    if point is None:
        raise WorldError(f"{world.called}: {key}: missing, expected one in the world or --{key} X Y")
    return point
