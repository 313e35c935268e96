"""One way to name a world everywhere: NAME, FILE or FAMILY:SEED."""

from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path

import numpy as np

from collplan_core.worlds.families import FAMILIES
from collplan_core.worlds.file import parse_text, read_world
from collplan_core.worlds.shapes import World, WorldError

UNKNOWN = "unknown"
"""The world of a robot without a given world: nothing is known to be in it."""
AROUND = 3.0
"""Distance around the origin to which an unknown world is drawn [m]."""
ARENAS = files("collplan_core.worlds") / "arenas"


def arena_names() -> list[str]:
    """Names of the shipped arenas."""
    return sorted(entry.name.removesuffix(".yaml") for entry in ARENAS.iterdir() if entry.name.endswith(".yaml"))


def load_world(spec: str | Path) -> World:
    """The world called NAME (a shipped arena), FILE (a path ending in .yaml or .yml) or FAMILY:SEED, as in `random:7`.

    A file is a world file, or a map of ROS's map_server. UNKNOWN is one without anything, bounds aside.

    Raises:
        WorldError: no such world, with near matches, or a file that does not hold one.
    """
    spec = str(spec)
    if spec == UNKNOWN:
        return World(UNKNOWN, (), np.zeros((0, 3)), (-AROUND, -AROUND, AROUND, AROUND), walled=False)
    if spec in arena_names():
        return parse_text((ARENAS / f"{spec}.yaml").read_text(encoding="utf-8"), spec, spec)
    if spec.endswith((".yaml", ".yml")) or Path(spec).is_file():
        return read_world(Path(spec))
    family, colon, seed = spec.partition(":")
    if family not in FAMILIES:
        raise _unknown(spec, family if colon else spec)
    if not (seed.isascii() and seed.isdecimal()):
        raise WorldError(f"world {spec!r}: got seed {seed!r}, expected a whole number from 0, as in {family}:7")
    return FAMILIES[family](int(seed))


def _unknown(spec: str, name: str) -> WorldError:
    known = {name: name for name in arena_names()} | {name: f"{name}:SEED" for name in FAMILIES}
    near = [known[match] for match in get_close_matches(name, known, n=3, cutoff=0.5)]
    hint = f"; did you mean {' or '.join(near)}?" if near else ""
    expected = ", ".join(known.values())
    return WorldError(f"world {spec!r}: unknown, expected one of {expected} or a path to a .yaml file{hint}")
