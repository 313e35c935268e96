"""What a picture of a run is called, and how that is fitted into it."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from collplan_core.parameters import Settings
from collplan_core.worlds import World
from collplan_ros.run.summary import counted_impacts

ELLIPSIS = "..."
LONGEST = 120
"""Characters of a world's name that are shown."""


def run_title(world: World, settings: Settings, simulated: bool) -> str:
    """World, strategy and seed of a run, and whether it was simulated, on one line."""
    # a world's name may be any text
    name = shortened(" ".join(world.name.split()), lambda text: len(text) <= LONGEST)
    kind = "simulated" if simulated else "measured"
    return f"{name}, {settings.planner.strategy}, seed {settings.simulator.seed} ({kind})"


def run_end(summary: Mapping[str, Any]) -> str:
    """How a run ended, on one line; `summary` is of summary.json."""
    arrival = summary["arrival_time_s"]
    end = f"goal reached in {arrival:.1f} s" if arrival is not None else summary["outcome"].replace("_", " ")
    return f"{end}, {summary['path_length_m']:.2f} m, {counted_impacts(summary['impacts'])}"


def wrapped(text: str, fits: Callable[[str], bool]) -> str:
    """The text in lines that fit; a word that fits into none is broken."""
    return "\n".join(part for line in text.splitlines() for part in _lines(line, fits))


def shortened(text: str, fits: Callable[[str], bool]) -> str:
    """The text, without its middle where all of it does not fit: both ends tell more."""
    kept = len(text)
    while not fits(shown := _without_middle(text, kept)) and kept > 0:
        kept -= 1
    return shown


def _lines(line: str, fits: Callable[[str], bool]) -> Iterator[str]:
    shown = ""
    for word in line.split():
        if fits(f"{shown} {word}".strip()):
            shown = f"{shown} {word}".strip()
            continue
        if shown:
            yield shown
        rest = word
        while len(rest) > 1 and not fits(rest):
            length = next((n for n in range(len(rest) - 1, 1, -1) if fits(rest[:n])), 1)
            yield rest[:length]
            rest = rest[length:]
        shown = rest
    yield shown


def _without_middle(text: str, kept: int) -> str:
    if kept >= len(text):
        return text
    tail = kept // 2
    return text[: kept - tail] + ELLIPSIS + text[len(text) - tail :]
