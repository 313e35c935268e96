"""Markers from a real cycle: what they show, and that they replace each other."""

import numpy as np
import pytest
from visualization_msgs.msg import Marker

from collplan_core.parameters import Settings
from collplan_ros.markers.plan_markers import plan_markers
from collplan_ros.messages.planner_clouds import ARROW_LENGTH
from fake_robot import GOAL, planned

SETTINGS = Settings()
BOUNCE = SETTINGS.with_values({"planner.strategy": "bounce", "time_to_goal.proposals": 100})


@pytest.fixture(scope="module")
def cycle():
    return planned(SETTINGS)


@pytest.fixture(scope="module")
def rollouts():
    return planned(BOUNCE)


def by_namespace(cycle, settings=SETTINGS):
    return {marker.ns: marker for marker in plan_markers(*cycle, GOAL, settings).markers}


def points(marker):
    return np.array([(p.x, p.y) for p in marker.points])


def test_one_marker_a_namespace_so_that_each_replaces_the_last_or_deletes_it(cycle, rollouts):
    made = plan_markers(*cycle, GOAL, SETTINGS).markers
    assert len({m.ns for m in made}) == len(made)
    assert {(m.id, m.header.frame_id, m.header.stamp.sec, m.header.stamp.nanosec) for m in made} == {
        (0, "map", 3, 250_000_000)
    }
    assert {m.ns for m in made if m.lifetime.sec} == {"robot", "scan"}
    now, then = by_namespace(cycle), by_namespace(rollouts, BOUNCE)
    assert now.keys() == then.keys()
    for name in ("rollouts", "remembered", "inferred"):
        assert (now[name].action, then[name].action) == (Marker.DELETE, Marker.ADD), name


def test_what_is_seen_and_planned_is_where_the_records_say(cycle):
    local_map, plan, _ = cycle
    markers = by_namespace(cycle)
    triangles = points(markers["free_space"]).reshape(-1, 3, 2)
    (a, b), (c, d) = (triangles[:, 1] - triangles[:, 0]).T, (triangles[:, 2] - triangles[:, 0]).T
    x, y = local_map.border_points.T
    shoelace = 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert 0.5 * (a * d - b * c).sum() == pytest.approx(shoelace, rel=1e-9)
    np.testing.assert_array_equal(points(markers["frontiers"]).reshape(-1, 4), local_map.segments)
    np.testing.assert_array_equal(points(markers["plan"]), plan.positions)
    shafts = points(markers["predicted"]).reshape(-1, 6, 2)[:, :2]
    np.testing.assert_allclose((shafts[:, 1] - shafts[:, 0]) / ARROW_LENGTH, local_map.predicted[:, 2:], atol=1e-9)
