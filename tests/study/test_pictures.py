"""The pictures of the documentation show what the code computes; that of the node graph is with the tests of nodes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import local_map
import maneuvers
import results_tables
import time_saved
import time_to_goal_cycle
from collplan_core.command import MANEUVERS, STOPPED
from collplan_core.local_map.contact_point import find_contact
from collplan_core.local_map.frontiers import BORDER_RUN, SHADOW_EDGE

# the oldest matplotlib calls pyparsing by names that it now warns of
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning:(matplotlib|pyparsing)")

DPI = 40


def is_drawn(path: Path) -> bool:
    with Image.open(path) as image:
        return len(image.getcolors()) > 20


def test_the_local_map_has_every_frontier_and_candidate(tmp_path):
    path = tmp_path / "local_map.png"
    drawn = local_map.draw(path, DPI)
    assert is_drawn(path)
    seen, plan = drawn.cycle.local_map, drawn.cycle.plan
    for kind in (SHADOW_EDGE, BORDER_RUN):
        assert len(drawn.frontiers[kind].get_segments()) == (seen.frontier_kind == kind).sum() > 0
    assert len(np.unique(seen.frontier_number)) >= 4
    assert drawn.n_predicted == len(seen.predicted) >= 2
    assert len(drawn.survivors.get_segments()) == len(plan.candidates.costs)
    assert len(drawn.all_candidates.get_segments()) == plan.n_before_pruning > len(plan.candidates.costs)


def test_candidates_of_one_direction_follow_each_other_and_the_best_is_drawn_last():
    cycle = local_map.shown_cycle()
    marks = local_map.candidate_marks(cycle.plan.candidates, cycle.settings)
    lines = np.array(marks.get_segments())
    longest = local_map.ROSETTE / cycle.settings.planner.n_speeds
    assert np.hypot(*(lines[:, 1] - lines[:, 0]).T).max() == pytest.approx(longest)
    best = cycle.plan.aim + local_map.ROSETTE / cycle.settings.robot.max_speed * cycle.plan.aim_velocity
    assert np.allclose(lines[-1, 1], best)


def test_the_three_maneuvers_are_those_of_the_controller(tmp_path):
    path = tmp_path / "maneuvers.png"
    drawn = maneuvers.draw(path, DPI)
    assert is_drawn(path)
    assert [each.course.maneuver for each in drawn] == [name for name in MANEUVERS if name != STOPPED]
    free, *contacts = drawn
    assert find_contact(free.cycle.plan.positions, free.cycle.local_map) is None
    for cycle, course in contacts:
        assert np.hypot(*(course.contact_path - cycle.plan.positions).T).max() > 0.05
        assert not cycle.local_map.contains(cycle.plan.positions).all()


@pytest.fixture(scope="module")
def bounce(tmp_path_factory):
    path = tmp_path_factory.mktemp("pictures") / "time_to_goal_cycle.png"
    drawn = time_to_goal_cycle.draw(path, DPI)
    assert is_drawn(path)
    return drawn


def test_the_plan_of_the_time_to_goal_cycle_bounces(bounce):
    cycle, plan = bounce.cycle, bounce.cycle.plan
    assert len(plan.contacts.times) >= 1
    before, after = time_to_goal_cycle.velocity_before(plan, 0), plan.contacts.velocities_after[0]
    center = np.array([np.interp(plan.contacts.times[0], plan.times, each) for each in plan.positions.T])
    out = (center - plan.contacts.points[0]) / cycle.settings.robot.radius
    assert np.hypot(*out) == pytest.approx(1.0, abs=0.05)
    assert out @ before < -0.08
    assert out @ after > 0.05
    assert len(bounce.fan.get_segments()) >= time_to_goal_cycle.FAN


def test_the_shortest_path_drawn_leads_round_what_is_remembered(bounce):
    cycle, path = bounce.cycle, bounce.path
    assert np.allclose(path[0], cycle.state.position)
    assert np.allclose(path[-1], cycle.world.goal, atol=0.05)
    middles = cycle.memory.remembered.pieces.reshape(-1, 2, 2).mean(axis=1)
    clearance = np.hypot(*(path[1:-1, None] - middles[None]).reshape(-1, 2).T)
    assert len(path) > 2
    assert clearance.min() > 0.9 * cycle.settings.robot.radius


def test_a_shortest_path_is_refused_where_there_is_none(bounce):
    cycle = bounce.cycle
    nowhere = replace(cycle.memory.paths, waypoint=np.full_like(cycle.memory.paths.waypoint, -1))
    with pytest.raises(LookupError, match="no path leads"):
        time_to_goal_cycle.shortest_path(nowhere, cycle.state.position)


def test_the_time_saved_has_a_bar_for_each_interval_of_the_table(tmp_path):
    path = tmp_path / "time_saved.png"
    drawn = time_saved.draw(path, DPI)
    assert is_drawn(path)
    saved = time_saved.time_saved(time_saved.RESULTS.read_text(encoding="utf-8"))
    assert len(saved) >= 7
    for k, bars in enumerate(drawn.values()):
        points, _, (intervals,) = bars
        assert np.allclose(points.get_xdata(), [row[k].value for row in saved.values()])
        ends = np.array(intervals.get_segments())[:, :, 0]
        assert np.allclose(ends, [row[k][1:] for row in saved.values()])


TABLE = """
## Deliberate bounces

| worlds | against `tolerate` | against `avoid` | against `stop_guarantee` |
|---|---|---|---|
| u (6) | -0.1 [-1.2, 0.5] | **5.5 [4.5, 6.5]** | 7 [6, 8] |

| worlds | something else |
|---|---|
| l | 3 |
"""


def test_a_table_is_read_by_its_heading_and_its_header():
    assert time_saved.time_saved(TABLE) == {"u (6)": [(-0.1, -1.2, 0.5), (5.5, 4.5, 6.5), (7.0, 6.0, 8.0)]}


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("# Results\n\nNothing yet.\n", "no section 'Deliberate bounces'"),
        (TABLE.replace("## Deliberate bounces", "## Others"), "no section"),
        (TABLE.replace("against `avoid`", "against `shun`"), "no table with the header"),
        (TABLE.replace("## Deliberate bounces", "## Deliberate bounces\n\n### Elsewhere"), "no table with the header"),
        (TABLE.replace(" | 7 [6, 8] |", " |"), "row 'u .6.': got 3 cells, expected 4"),
        (TABLE.replace("7 [6, 8]", "7"), "cell '7': expected a number and its interval"),
    ],
)
def test_a_document_without_the_table_is_refused(wrong, said):
    with pytest.raises(results_tables.TableError, match=said):
        time_saved.time_saved(wrong)
