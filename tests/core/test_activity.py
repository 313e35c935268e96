"""What the controller says it does: a deliberate bounce is told from free space, a stop comes with its reason."""

import numpy as np

from collplan_core.command import (
    BOUNDARY_FOLLOWING,
    FLOW_THROUGH,
    FREE_SPACE,
    HAND,
    STOPPED,
    Command,
    stopped,
)
from collplan_core.control.activity import BOUNCE, MANEUVER, TRACK, Activity, describe
from collplan_core.plan import Contacts, Plan, timed_path

MANEUVERS_AT_A_WALL = BOUNDARY_FOLLOWING, FLOW_THROUGH


def plan(begin: float = 0.0, end: float = 4.0) -> Plan:
    line = np.array([[0.0, 0.0], [1.0, 0.0]])
    return timed_path(begin, np.array([begin, end]), line, 0.0 * line)


def contacts_at(*when: float) -> Contacts:
    """Each at x = its time, y = 1.2."""
    points = np.array([[time, 1.2] for time in when]).reshape(-1, 2)
    return Contacts(np.array(when), points, np.zeros_like(points))


def command(maneuver: str) -> Command:
    return stopped("no plan yet") if maneuver == STOPPED else Command(np.ones(2), 0.0, maneuver, np.zeros(2))


def test_by_hand_each_activity_with_its_reason():
    one, three, none = contacts_at(0.41), contacts_at(0.05, 0.41, 3.0), Contacts.none()
    table = [
        (command(FREE_SPACE), plan(), three, 0.27, BOUNCE, "0.41, 1.20"),
        (command(FREE_SPACE), plan(), three, 0.55, BOUNCE, "0.41, 1.20"),
        (command(FREE_SPACE), plan(), one, 0.25, TRACK, "follows"),
        (command(FREE_SPACE), plan(), one, 0.57, TRACK, "follows"),
        (command(FREE_SPACE), plan(end=1.0), none, 1.1, TRACK, "end of the plan"),
        (command(HAND), plan(), contacts_at(1.0), 1.0, HAND, "hand"),
        (stopped("too dark"), None, none, 1.0, STOPPED, "too dark"),
    ]
    for given_, plan_, foreseen, now, name, words in table:
        activity = describe(given_, plan_, foreseen, now)
        assert (activity.name, words in activity.reason) == (name, True), activity


def test_an_age_that_grows_is_no_news():
    young, old, other = (
        describe(stopped(f"{what} s old"), None, Contacts.none(), 0.0) for what in ("pose 0.1", "pose 12.3", "scan 0.7")
    )
    assert young.differs(None)
    assert not old.differs(young)
    assert old.differs(other)
    assert old.differs(Activity(TRACK, old.reason))
    following, flowing = (describe(command(each), plan(), Contacts.none(), 1.0) for each in MANEUVERS_AT_A_WALL)
    assert following.name == flowing.name == MANEUVER
    assert following.differs(flowing)
