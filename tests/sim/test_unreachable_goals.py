"""Goals that cannot be reached are given up with a reason, and those that only look so are reached."""

import re
from dataclasses import replace

import numpy as np
import pytest
from shifted_starts import each_shift, shifted

from collplan_core.evaluation.run_end import ABORTED, REACHED, STUCK
from collplan_core.parameters import Settings
from collplan_core.worlds import Mover, World, parse_world
from omnipuck_sim.trial import run_trial

Box = tuple[float, float, float, float]
CLOSED, NO_NEARER = "closed off", "without coming nearer"
STANDS = f"{CLOSED}|less than 0.05 m away within"
"""With 2 mm of noise in the poses so narrow a door seems now closed, now open: a robot may stand before it."""


def room(size: float, start: tuple[float, float], goal: tuple[float, float], *boxes: Box) -> World:
    corners = [[[a, b], [c, b], [c, d], [a, d]] for a, b, c, d in boxes]
    ends = {"bounds": [0.0, 0.0, size, size], "start": list(start), "goal": list(goal)}
    return parse_world({"name": "room", "polygons": corners, **ends}, "room")


def door(width: float) -> World:
    lower, upper = 1.5 - 0.5 * width, 1.5 + 0.5 * width
    return room(3.0, (0.5, 1.5), (2.5, 1.5), (1.45, 0.0, 1.55, lower), (1.45, upper, 1.55, 3.0))


def pocket(depth: float) -> World:
    """A U, 1.2 m wide and open toward the robot, between it and the goal."""
    end, low, high = 3.0 + depth, 3.4, 4.6
    walls = (3.0, low - 0.1, end + 0.1, low), (3.0, high, end + 0.1, high + 0.1), (end, low, end + 0.1, high)
    return room(9.0, (2.0, 4.0), (end + 1.0, 4.0), *walls)


BOX = room(7.0, (0.5, 0.5), (3.5, 3.5), (2, 2, 5, 2.1), (2, 4.9, 5, 5), (2, 2, 2.1, 5), (4.9, 2, 5, 5))
SLOT = room(4.0, (1.0, 2.0), (3.5, 2.0), (2, 1, 4, 1.95), (2, 2.05, 4, 3))
GAP = 0.5 * 0.17 / 2.0**0.5
CORNERS = room(4.0, (0.5, 3.5), (3.5, 0.5), (0, 0, 2 - GAP, 2 - GAP), (2 + GAP, 2 + GAP, 4, 4))
"""A gap of 0.17 m between two corners."""


def at_wall(distance: float) -> World:
    return room(4.0, (1.0, 2.0), (4.0 - distance, 2.0))


CASES = {
    "closed box of 3 m": (BOX, "bounce", CLOSED, 20.0),
    "gap 1 cm too narrow": (CORNERS, "avoid", CLOSED, 6.0),
    "pocket 0.6 m deep": (pocket(0.6), "high_risk", NO_NEARER, 30.0),
}
MORE = {
    "closed box, no memory": (BOX, "harness", NO_NEARER, 40.0),
    "door 15 mm too narrow": (door(0.165), "avoid", CLOSED, 15.0),
    "slot, no memory": (SLOT, "low_risk", NO_NEARER, 60.0),
    "door 5 mm too narrow": (door(0.175), "bounce", STANDS, 15.0),
}
NEAR = {
    "door 5 mm wider than the robot": (door(0.185), "avoid", 5.0),
    "pocket 4 m deep": (pocket(4.0), "bounce", 20.0),
    "5 cm from a wall": (at_wall(0.05), "bounce", 4.0),
    "5 cm from a wall, no memory": (at_wall(0.05), "harness", 4.0),
}
MORE_NEAR = {
    "1 cm from a wall": (at_wall(0.01), "avoid", 6.0),
}


def cases(often: dict, seldom: dict) -> list:
    """The rows of a test, the second ones of the long tests alone."""
    return [pytest.param(*case, id=name) for name, case in often.items()] + [
        pytest.param(*case, id=name, marks=pytest.mark.soak) for name, case in seldom.items()
    ]


def trial(world: World, strategy: str):
    return run_trial(world, Settings().with_values({"planner.strategy": strategy, "trial.timeout": 100.0}), seed=0)


@pytest.mark.parametrize(("world", "strategy", "end", "longest"), cases(CASES, MORE))
def test_a_goal_that_cannot_be_reached_is_given_up_with_a_reason_before_long(world, strategy, end, longest):
    result = trial(world, strategy)
    assert result.outcome in ((ABORTED, STUCK) if end == STANDS else (ABORTED,)), result.reason
    assert re.search(end, result.reason)
    assert result.path_length < longest


@each_shift
@pytest.mark.parametrize(("world", "strategy", "longest"), cases(NEAR, MORE_NEAR))
def test_a_goal_that_only_looks_so_is_reached(world, strategy, longest, shift):
    result = trial(shifted(world, shift), strategy)
    assert result.outcome == REACHED, result.reason
    assert result.path_length < longest


ON_GOAL = Mover(0.15, np.array([[2.5, 2.6], [2.5, 1.5]]), 0.8, pause=6.0, rounds=1)
DOOR_SHUTS = Mover(0.29, np.array([[1.9, 2.1], [1.8, 1.5]]), 0.6, to_and_fro=False, delay=0.3)


@pytest.mark.parametrize(
    "strategy", ["avoid", *(pytest.param(name, marks=pytest.mark.soak) for name in ("bounce", "low_risk"))]
)
@pytest.mark.parametrize("mover", [pytest.param(ON_GOAL, id="goal"), pytest.param(DOOR_SHUTS, id="door")])
def test_who_stands_on_the_goal_or_in_the_only_door_is_waited_for_or_named_before_long(mover, strategy):
    place = door(0.6) if mover is DOOR_SHUTS else room(3.0, (0.5, 1.5), (2.5, 1.5))
    world = replace(place, movers=(mover,))
    settings = Settings().with_values({"planner.strategy": strategy, "trial.timeout": 30.0})
    result = run_trial(world, settings, seed=0)
    assert result.outcome == REACHED or (result.outcome == ABORTED and "a mover" in result.reason), result.reason
