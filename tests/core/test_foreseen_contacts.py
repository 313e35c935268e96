"""The contacts a plan foresees, worked by hand."""

import numpy as np
import pytest

from collplan_core.paper_planner.foreseen_contacts import foreseen_contacts
from scenes import RADIUS, SETTINGS, box, map_of, world_of

TIMES = np.linspace(7.0, 8.0, 64)
E, MU = SETTINGS.rebound.restitution, SETTINGS.rebound.friction


def straight(start, end) -> tuple[np.ndarray, np.ndarray]:
    start, end = np.array(start, dtype=float), np.array(end, dtype=float)
    share = (TIMES - TIMES[0])[:, None] / (TIMES[-1] - TIMES[0])
    return start + share * (end - start), np.broadcast_to(end - start, (len(TIMES), 2)).copy()


def test_by_hand_an_observed_boundary_on_the_way():
    """Wall at x = 0.39: the centre gets to x = 0.3 after 0.6 of the way, the ring touches at x = 0.39."""
    local_map = map_of(world_of([box(0.3 + RADIUS, -4.0, 2.0, 4.0)]))
    contacts = foreseen_contacts(local_map, TIMES, *straight((0, 0), (0.5, 0.2)), SETTINGS)
    np.testing.assert_allclose(contacts.times, [7.6], atol=1e-3)
    np.testing.assert_allclose(contacts.points, [[0.3 + RADIUS, 0.12]], atol=1e-3)
    np.testing.assert_allclose(contacts.velocities_after, [[-E * 0.5, 0.2 - 0.2 / 3.0]], atol=1e-6)


def test_by_hand_a_predicted_boundary_behind_the_end():
    """A corridor wall goes on beyond the map at y = 0.2: a plan that ends slanting up meets it just outside."""
    local_map = map_of(world_of([box(-4.0, 0.2 + RADIUS, 4.0, 0.6)]))
    path, velocities = straight((0.0, 0.0), (0.6, 0.15))
    contacts = foreseen_contacts(local_map, TIMES, path, velocities, SETTINGS)
    # 0.05 m more at 0.15 m/s
    assert len(contacts.times) == (SETTINGS.planner.rebound_horizon >= 0.05 / 0.15)
    longer = SETTINGS.with_values({"planner.rebound_horizon": 0.4})
    contacts = foreseen_contacts(local_map, TIMES, path, velocities, longer)
    np.testing.assert_allclose(contacts.times, [8.0 + 1 / 3], atol=1e-6)
    np.testing.assert_allclose(contacts.points, [[0.8, 0.2 + RADIUS]], atol=1e-6)
    np.testing.assert_allclose(contacts.velocities_after, [[0.6 - MU * (1.0 + E) * 0.15, -E * 0.15]], atol=1e-6)


@pytest.mark.parametrize("end", [(0.2, 0.1), (-0.5, 0.0)])
def test_free_space_foresees_nothing(end):
    local_map = map_of(world_of([box(0.3 + RADIUS, -4.0, 2.0, 4.0)]))
    assert len(foreseen_contacts(local_map, TIMES, *straight((0, 0), end), SETTINGS).times) == 0


def test_a_plan_that_ends_at_rest_foresees_nothing_behind_its_end():
    local_map = map_of(world_of([box(-4.0, 0.2 + RADIUS, 4.0, 0.6)]))
    path, _ = straight((0.0, 0.0), (0.6, 0.15))
    assert len(foreseen_contacts(local_map, TIMES, path, np.zeros_like(path), SETTINGS).times) == 0
