"""Goals that cannot be reached are given up with a reason, and those that only look so are reached."""

import re

import pytest
from shifted_starts import each_shift, shifted

from collplan_core.evaluation.run_end import ABORTED, REACHED, STUCK
from collplan_core.parameters import Settings
from collplan_core.worlds import World, parse_world
from omnipuck_sim.trial import run_trial

Box = tuple[float, float, float, float]
CLOSED, NO_NEARER = "closed off", "without coming nearer"
STANDS = f"{CLOSED}|less than 0.05 m away within"
"""With 2 mm of noise in the poses so narrow a door seems now closed, now open: a robot may stand before it."""


def room(size: float, start: tuple[float, float], goal: tuple[float, float], *boxes: Box) -> World:
    """A square room with boxes x0, y0, x1, y1 in it [m]."""
    corners = [[[a, b], [c, b], [c, d], [a, d]] for a, b, c, d in boxes]
    ends = {"bounds": [0.0, 0.0, size, size], "start": list(start), "goal": list(goal)}
    return parse_world({"name": "room", "polygons": corners, **ends}, "room")


def door(width: float) -> World:
    """A room of 3 m, parted by a wall that has a door."""
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


soak = pytest.mark.soak
CASES = {
    "closed box of 3 m": (BOX, "bounce", CLOSED, 20.0),
    "the same, no memory": (BOX, "harness", NO_NEARER, 40.0),
    "door 5 mm too narrow": (door(0.175), "avoid", STANDS, 15.0),
    "door 15 mm too narrow": (door(0.165), "avoid", CLOSED, 15.0),
    "door 5 mm wider than the robot": (door(0.185), "avoid", REACHED, 5.0),
    "gap 1 cm too narrow": (CORNERS, "avoid", CLOSED, 6.0),
    "pocket 4 m deep": (pocket(4.0), "bounce", REACHED, 20.0),
    "pocket 0.6 m deep": (pocket(0.6), "high_risk", NO_NEARER, 30.0),
    "5 cm from a wall": (at_wall(0.05), "bounce", REACHED, 4.0),
    "5 cm from a wall, no memory": (at_wall(0.05), "harness", REACHED, 4.0),
}
MORE = {
    "closed box, avoid": (BOX, "avoid", CLOSED, 20.0),
    "slot": (SLOT, "bounce", CLOSED, 20.0),
    "slot, no memory": (SLOT, "low_risk", NO_NEARER, 60.0),
    "door, bounce": (door(0.175), "bounce", STANDS, 15.0),
    "door 15 mm too narrow, bounce": (door(0.165), "bounce", CLOSED, 15.0),
    "gap, bounce": (CORNERS, "bounce", CLOSED, 6.0),
    "pocket, avoid": (pocket(4.0), "avoid", REACHED, 20.0),
    "1 cm from a wall": (at_wall(0.01), "avoid", REACHED, 6.0),
    "1 cm from a wall, no memory": (at_wall(0.01), "low_risk", REACHED, 4.0),
}


@each_shift
@pytest.mark.parametrize(
    ("world", "strategy", "end", "longest"),
    [pytest.param(*case, id=name) for name, case in CASES.items()]
    + [pytest.param(*case, id=name, marks=soak) for name, case in MORE.items()],
)
def test_a_goal_is_reached_or_given_up_with_a_reason_before_long(world, strategy, end, longest, shift):
    settings = Settings().with_values({"planner.strategy": strategy, "trial.timeout": 100.0})
    result = run_trial(shifted(world, shift), settings, seed=0)
    ends = {REACHED: (REACHED,), STANDS: (ABORTED, STUCK)}.get(end, (ABORTED,))
    assert result.outcome in ends, result.reason
    assert end == REACHED or re.search(end, result.reason)
    assert result.path_length < longest
