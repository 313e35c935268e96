"""Impacts as they happen, by the plans before them."""

import numpy as np
import pytest

from collplan_core.impact import POSES, Impact
from collplan_core.plan import Contacts, timed_path
from collplan_ros.view.scene import MOST, ShownImpacts

POINT, NORMAL = np.array([1.0, 0.0]), np.array([-1.0, 0.0])


def hit_at(time: float, speed: float) -> Impact:
    return Impact(time, POINT, NORMAL, np.array([speed, 0.1]), np.array([-0.5 * speed, 0.1]), POSES)


def contact_at(time: float) -> Contacts:
    return Contacts(np.array([time]), POINT[None], np.array([[-0.5, 0.0]]), NORMAL[None])


def hit_with(speed: float, *plans: tuple[float, Contacts]):
    impacts = ShownImpacts()
    for made, contacts in plans:
        impacts.planned(timed_path(made, made + np.array([0.0, 1.0]), *np.zeros((2, 2, 2)), contacts=contacts))
    impacts.happened(hit_at(1.0, speed))
    (impact,) = impacts.part
    return impact


def test_kind_and_speed_are_judged_by_the_plans_so_far():
    for speed, plans, kind in (
        (0.8, [(0.7, contact_at(1.02)), (0.8, contact_at(1.02))], "deliberate"),
        (0.1, [(0.7, contact_at(1.02)), (0.8, contact_at(1.02))], "foreseen"),
        (0.8, [(0.7, contact_at(1.0)), (0.9, Contacts.none())], "other"),
        (-0.1, [], "other"),
    ):
        impact = hit_with(speed, *plans)
        assert (impact["kind"], impact["speed"]) == (kind, pytest.approx(max(1000 * speed, 0), abs=1))


def test_what_was_sent_stays_and_the_oldest_go():
    impacts = ShownImpacts()
    impacts.happened(hit_at(1.0, 0.5))
    sent = impacts.part
    for time in range(2, MOST + 5):
        impacts.happened(hit_at(float(time), 0.5))
    assert len(sent) == 1
    assert len(impacts.part) == MOST
    assert impacts.part[-1]["t"] == MOST + 4
    assert impacts.counts == {"deliberate": 0, "foreseen": 0, "other": MOST + 4}
