"""Loads the worlds of a study from the texts that name them."""

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from collplan_core.worlds import World, WorldError, load_world
from collplan_core.worlds.families import FAMILIES
from collplan_study.barn.data_set import barn_files, barn_rules, load_barn, optimal_lengths
from collplan_study.barn.sdf import is_sdf, load_sdf
from collplan_study.errors import StudyError

Point = Sequence[float] | None

BARN = "barn"


@dataclass(frozen=True, eq=False)
class Source:
    """A world of a study, and what its data set prescribes.

    Attributes:
        world: with its start and goal.
        family: its family; the world's own name where it has none.
        values: parameters that the rules of its data set prescribe, by key; --set overrides them.
        optimal_length: length of the data set's shortest path from start to goal [m]; None without one.
    """

    world: World
    family: str
    values: Mapping[str, Any] = field(default_factory=dict)
    optimal_length: float | None = None


def load_sources(texts: Sequence[str], start: Point, goal: Point, barn_scale: float = 1.0) -> tuple[Source, ...]:
    """Every world that the texts name, in their order.

    Args:
        texts: as `--worlds` takes them.
        start, goal: x, y [m] that replace the worlds' own; None keeps them. Worlds of barn:DIR refuse both.
        barn_scale: factor on the size of the worlds of barn:DIR.

    Raises:
        WorldError: a world cannot be read or used.
        StudyError: the options do not fit the worlds, or two worlds have the same name, which would give them the same
            noise and mix their rows.
    """
    sources = tuple(source for text in texts for source in _sources_of(text, start, goal, barn_scale))
    if barn_scale != 1.0 and not any(source.family == BARN for source in sources):
        raise StudyError(f"--barn-scale: got {barn_scale:g} without its worlds, expected --worlds {BARN}:DIR")
    for name, count in Counter(source.world.name for source in sources).items():
        if count > 1:
            raise StudyError(f"--worlds: {count} worlds are called {name}, expected each once")
    return sources


def _sources_of(text: str, start: Point, goal: Point, barn_scale: float) -> Iterator[Source]:
    family, colon, rest = text.partition(":")
    if colon and family == BARN:
        yield from _barn_sources(text, rest, start or goal, barn_scale)
    elif is_sdf(Path(text)):
        yield _sdf_source(text, start, goal)
    elif family in FAMILIES:
        for seed in _seeds(text, rest):
            yield Source(_moved(load_world(f"{family}:{seed}"), start, goal), family)
    else:
        world = _moved(load_world(text), start, goal)
        yield Source(world, world.name)


def _barn_sources(text: str, rest: str, moved: Point, scale: float) -> Iterator[Source]:
    # shells expand ~ at the beginning of a word alone
    folder = Path(rest).expanduser()
    if not rest:
        raise StudyError(f"{text}: names no folder, expected {BARN}:DIR")
    if moved:
        raise StudyError(f"{text}: has a start and a goal of its own, leave out --start and --goal")
    lengths = optimal_lengths(folder, scale)
    for path in barn_files(folder).values():
        world = load_barn(path, scale)
        yield Source(world, BARN, barn_rules(scale), lengths.get(world.name))


def _sdf_source(text: str, start: Point, goal: Point) -> Source:
    if start is None or goal is None:
        raise StudyError(f"{text}: SDF holds neither start nor goal, expected --start X Y and --goal X Y")
    world = load_sdf(Path(text), np.array(start), np.array(goal))
    return Source(world, world.name)


def _seeds(text: str, rest: str) -> Sequence[int | str]:
    if "-" not in rest:
        return [rest]
    match = re.fullmatch(r"([0-9]+)-([0-9]+)", rest)
    if match is None or int(match[1]) > int(match[2]):
        raise WorldError(f"world {text!r}: got seeds {rest!r}, expected A-B with A up to B, as in random:0-99")
    return range(int(match[1]), int(match[2]) + 1)


def _moved(world: World, start: Point, goal: Point) -> World:
    try:
        return replace(
            world,
            start=world.start if start is None else np.array(start),
            goal=world.goal if goal is None else np.array(goal),
        )
    except WorldError as error:
        raise WorldError(f"{world.called}: {error}") from None
