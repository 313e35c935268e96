"""Loads the worlds of a study from the texts that name them."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from collplan_core.worlds import World, WorldError, load_world, read_world
from collplan_core.worlds.families import FAMILIES
from collplan_study.errors import StudyError

Point = Sequence[float] | None


@dataclass(frozen=True, eq=False)
class Source:
    """A world of a study.

    Attributes:
        world: with its start and goal.
        family: its family; the world's own name where it has none.
    """

    world: World
    family: str


def load_sources(texts: Sequence[str], start: Point, goal: Point) -> tuple[Source, ...]:
    """Every world that the texts name, in their order.

    Args:
        texts: values of `--worlds`.
        start, goal: x, y [m] that replace the worlds' own; None keeps them.

    Raises:
        WorldError: a world cannot be read or used.
        StudyError: two worlds have the same name, which would give them the same noise and mix their rows.
    """
    sources = tuple(
        Source(_moved(world, start, goal), family or world.name) for text in texts for world, family in _worlds_of(text)
    )
    for name, count in Counter(source.world.name for source in sources).items():
        if count > 1:
            raise StudyError(f"--worlds: {count} worlds are called {name}, expected each once")
    return sources


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


def _moved(world: World, start: Point, goal: Point) -> World:
    try:
        return replace(
            world,
            start=world.start if start is None else np.array(start),
            goal=world.goal if goal is None else np.array(goal),
        )
    except WorldError as error:
        raise WorldError(f"{world.called}: {error}") from None
