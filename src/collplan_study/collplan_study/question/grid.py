"""The grid of a study: every trial, in the order of its tables."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from itertools import product
from typing import Any

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.planners import first_memory, map_period_of
from collplan_core.worlds import World, WorldError, check_route
from collplan_study.errors import StudyError
from collplan_study.question.question import Question, parse_axes
from collplan_study.question.sources import Source
from collplan_study.question.specification import specification_of

STRATEGY, MAP_PERIOD, ENGINE = "planner.strategy", "planner.map_period", "simulator.engine"

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
class TrialGrid:
    """All trials of a study.

    Attributes:
        tasks: the trials in the order of the tables: cell by cell, and in each cell the trials 0, 1, ...
        axes: keys of the --set parameters, which have columns of their own.
    """

    tasks: tuple[Task, ...]
    axes: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.tasks)

    def __iter__(self) -> Iterator[Task]:
        return iter(self.tasks)


def trial_seed(study_seed: int, world: str, trial: int) -> int:
    """31-bit seed of a trial. It depends on neither strategy nor parameters, so that these are compared at equal noise.

    Args:
        study_seed: seed of the whole study.
        world: name of the world.
        trial: number of the trial in its cell.
    """
    digest = sha256(f"{study_seed}/{world}/{trial}".encode()).digest()
    return int.from_bytes(digest[:4], "big") >> 1


def make_grid(
    question: Question, sources: Sequence[Source], ablations: Mapping[str, Mapping[str, Any]] = NO_ABLATION
) -> TrialGrid:
    """The grid of a question over its worlds.

    Args:
        question: question of the study; its worlds are `sources`.
        sources: the worlds.
        ablations: changed parameters by name of the ablation; they override the axes. The empty name changes nothing.

    Raises:
        StudyError: the grid is empty, or a value is given twice.
        ParameterError: an unknown parameter or a value out of its range.
        WorldError: a world without a route from start to goal for the robot.
    """
    axes = parse_axes(question.values)
    points = [dict(zip(axes, values, strict=True)) for values in product(*axes.values())]
    cells = [
        (source, *_cell(source, name, changes, {**point, **strategy, ENGINE: question.engine}), _trials(question, name))
        for name, changes in ablations.items()
        for source, strategy, point in product(sources, _strategies(question, name), points)
    ]
    if not cells:
        raise StudyError("the grid is empty: expected at least one world")
    _check_routes((source.world, settings) for source, _, settings, _ in cells)
    tasks: list[Task] = []
    for source, labels, settings, trials in cells:
        for trial in range(trials):
            seed = trial_seed(question.seed, source.world.name, trial)
            tasks.append(Task(len(tasks), {**labels, "trial": trial, "seed": seed}, source.world, settings, seed))
    return TrialGrid(tuple(tasks), tuple(axes))


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
    """T_map [s] where the question names none: those of its specification, else the strategy's own."""
    evaluated = specification_of(question.bounces).map_periods
    return evaluated.get(strategy) or (map_period_of(Settings().with_values({STRATEGY: strategy}).planner),)


def _cell(
    source: Source, ablation: str, changes: Mapping[str, Any], point: Mapping[str, Any]
) -> tuple[dict[str, Any], Settings]:
    """Labels and settings of a cell: axes, strategy and engine of `point`, and over them the ablation's changes."""
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
    return labels, settings


def _check_routes(cells: Iterable[tuple[World, Settings]]) -> None:
    """Checks start, goal and route in each world, once for each radius of the robot and tolerance of the goal."""
    sizes = ((world, settings.robot.radius, settings.planner.goal_tolerance) for world, settings in cells)
    for world, radius, tolerance in dict.fromkeys(sizes):
        check_route(world, _end(world, "start", world.start), _end(world, "goal", world.goal), radius, tolerance)


def _end(world: World, key: str, point: np.ndarray | None) -> np.ndarray:
    if point is None:
        raise WorldError(f"{world.called}: {key}: missing, expected one in the world or --{key} X Y")
    return point
