"""The pictures of the documentation are made, and show what the code computes."""

import pytest
from PIL import Image

import local_map
import maneuvers
import time_saved
import time_to_goal_cycle
from collplan_core.command import MANEUVERS, STOPPED

# the oldest matplotlib calls pyparsing by names that it now warns of
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning:(matplotlib|pyparsing)")


def test_each_is_drawn_and_holds_what_it_shows(tmp_path):
    drawn = {}
    for module in (local_map, maneuvers, time_to_goal_cycle, time_saved):
        path = tmp_path / f"{module.__name__}.png"
        drawn[module] = module.draw(path, 40)
        with Image.open(path) as image:
            assert len(image.getcolors()) > 20, path.name
    plan = drawn[local_map].cycle.plan
    assert len(drawn[local_map].survivors.get_segments()) == len(plan.candidates.costs) > 0
    assert [each.course.maneuver for each in drawn[maneuvers]] == [name for name in MANEUVERS if name != STOPPED]
    assert len(drawn[time_to_goal_cycle].cycle.plan.contacts.times) >= 1
