"""Decisions of the planner at an input or at a tick, which the caller of its loop passes on."""

from dataclasses import dataclass

from collplan_core.goal import Goal
from collplan_core.local_map import LocalMap
from collplan_core.plan import Plan
from collplan_core.time_to_goal_planner.boundary_memory.working import RememberedBoundaries

INFO, WARNING, ERROR = "info", "warning", "error"


@dataclass(frozen=True, eq=False)
class Cycle:
    """A planning cycle that ended with a plan."""

    plan: Plan  # the plan chosen, with the time until which it may be followed
    local_map: LocalMap  # local map that it was made in
    boundaries: RememberedBoundaries | None
    """Boundaries that the planner remembers; None where it has no memory of them."""


@dataclass(frozen=True)
class Notice:
    """A line for the person at the terminal: INFO, WARNING or ERROR, and the text."""

    level: str
    text: str


Decision = Goal | Cycle | Notice
"""A goal is announced whenever it is new or its status or stamp changed."""
