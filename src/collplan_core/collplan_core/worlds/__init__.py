"""Worlds: what they are, their files, the shipped arenas, and seeded families."""

from collplan_core.worlds.file import parse_world, read_world, save_world, world_text
from collplan_core.worlds.load import UNKNOWN, arena_names, load_world
from collplan_core.worlds.movers import Mover
from collplan_core.worlds.route import check_route
from collplan_core.worlds.shapes import World, WorldError, world_segments

__all__ = [
    "UNKNOWN",
    "Mover",
    "World",
    "WorldError",
    "arena_names",
    "check_route",
    "load_world",
    "parse_world",
    "read_world",
    "save_world",
    "world_segments",
    "world_text",
]
