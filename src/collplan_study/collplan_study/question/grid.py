"""The grid of a study: its worlds, and every trial in the order of the tables."""

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.planners import first_memory, map_period_of
from collplan_core.worlds import World, WorldError, check_route, load_world, read_world
from collplan_core.worlds.families import FAMILIES
from collplan_study.errors import StudyError
from collplan_study.question.question import Question, parse_axes
from collplan_study.question.specification import Changes

STRATEGY, MAP_PERIOD, ENGINE = "planner.strategy", "planner.map_period", "simulator.engine"
NO_ABLATION: Changes = {"": {}}
Point = Sequence[float]


@dataclass(frozen=True, eq=False)
class Source:
    """A world of a study, with its start and goal."""

    world: World
    family: str
    """The world's own name where it has none."""


def load_sources(texts: Sequence[str], start: Point | None = None, goal: Point | None = None) -> tuple[Source, ...]:
    """Every world that values of `--worlds` name, in their order; a start or goal x, y [m] replaces the worlds' own."""
    given = (("start", start), ("goal", goal))
    ends: dict[str, Any] = {key: np.array(point) for key, point in given if point is not None}
    found = [(replace(world, **ends), family) for text in texts for world, family in _worlds_of(text)]
    for name, count in Counter(world.name for world, _ in found).items():
        if count > 1:  # they would have the same noise, and their rows would mix
            raise StudyError(f"--worlds: {count} worlds are called {name}, expected each once")
    return tuple(Source(world, family or world.name) for world, family in found)


def _worlds_of(text: str) -> Iterator[tuple[World, str]]:
    """Worlds that a text names, each with its family; an empty family where it has none."""
    family, _, rest = text.partition(":")
    if family in FAMILIES:
        yield from ((load_world(f"{family}:{seed}"), family) for seed in _seeds(text, rest))
    elif Path(text).is_dir():
        files = sorted(path for path in Path(text).iterdir() if path.suffix in (".yaml", ".yml"))
        if not files:
            raise WorldError(f"{text}: no world files, expected a folder that holds some, .yaml")
        yield from ((read_world(path), Path(text).resolve().name) for path in files)
    else:
        yield load_world(text), ""


def _seeds(text: str, rest: str) -> Sequence[int | str]:
    if "-" not in rest:
        return [rest]
    match = re.fullmatch(r"([0-9]+)-([0-9]+)", rest)
    if match is None or int(match[1]) > int(match[2]):
        raise WorldError(f"world {text!r}: got seeds {rest!r}, expected A-B with A up to B, as in random:0-99")
    return range(int(match[1]), int(match[2]) + 1)


@dataclass(frozen=True, eq=False)
class Task:
    """One trial to be run."""

    index: int
    """Its place in the grid."""
    labels: Mapping[str, Any]
    """Columns of its row that are known before it is run."""
    world: World
    settings: Settings
    seed: int


def trial_seed(study_seed: int, world: str, trial: int) -> int:
    """31-bit seed of a trial. Strategies and parameters, on which it does not depend, are compared at equal noise."""
    digest = sha256(f"{study_seed}/{world}/{trial}".encode()).digest()
    return int.from_bytes(digest[:4], "big") >> 1


def make_grid(question: Question, sources: Sequence[Source], ablations: Changes = NO_ABLATION) -> tuple[Task, ...]:
    """The trials of a question over its worlds, which are `sources`: cell by cell, in each the trials 0, 1, ...

    Ablations override the axes. A parameter, or a world without a route for the robot, is refused before any trial.
    """
    axes = parse_axes(question.values)
    points = [dict(zip(axes, values, strict=True)) for values in product(*axes.values())]
    tasks: list[Task] = []
    routes: dict[tuple[World, float, float], None] = {}
    for name, changes in ablations.items():
        trials = question.ablation_trials if name and question.ablation_trials else question.trials
        for source, strategy, point in product(sources, _strategies(question, name), points):
            world, asked = source.world, {**point, **strategy, ENGINE: question.engine}
            settings = Settings().with_values({**asked, **changes})
            first_memory(settings, world)  # refused before the first trial
            routes[world, settings.robot.radius, settings.planner.goal_tolerance] = None
            known = settings.values()
            labels = {
                "world": world.name,
                "family": source.family,
                "ablation": name,
                "engine": question.engine,
                "strategy": strategy[STRATEGY],
                "map_period_s": strategy[MAP_PERIOD],
                **{key: known[key] for key in axes},
            }
            for trial in range(trials):
                seed = trial_seed(question.seed, world.name, trial)
                tasks.append(Task(len(tasks), {**labels, "trial": trial, "seed": seed}, world, settings, seed))
    if not tasks:
        raise StudyError("the grid is empty: expected at least one world")
    for world, radius, tolerance in routes:
        check_route(world, _end(world, "start"), _end(world, "goal"), radius, tolerance)
    return tuple(tasks)


def _strategies(question: Question, ablation: str) -> list[dict[str, Any]]:
    """The parameters of every strategy and T_map that an ablation is run with."""
    chosen = question.ablation_strategies if ablation else None
    asked = []
    for strategy in chosen or question.strategies:
        own = map_period_of(Settings().with_values({STRATEGY: strategy}).planner)
        periods = question.map_periods or question.specification.map_periods.get(strategy, (own,))
        asked += [{STRATEGY: strategy, MAP_PERIOD: period} for period in periods]
    return asked


def _end(world: World, key: str) -> np.ndarray:
    point: np.ndarray | None = getattr(world, key)
    if point is None:
        raise WorldError(f"{world.called}: {key}: missing, expected one in the world or --{key} X Y")
    return point
