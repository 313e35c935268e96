"""What frees a robot that is held: a person, by a new goal or by resume, and nothing else."""

from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.control.interlock import Interlock

FIRST, SECOND = bytes(16), bytes(range(16))


def test_the_first_goal_heard_of_may_be_one_of_before_and_the_next_is_new():
    held = Interlock("just started")
    assert not held.is_new(FIRST, active=True)
    known = held.after_goal(FIRST)
    assert known.reason == "just started"
    assert not known.is_new(FIRST, active=True)
    assert known.is_new(SECOND, active=True)
    assert not known.is_new(SECOND, active=False)


def test_a_goal_heard_of_before_is_not_new_whatever_was_heard_since():
    lock = Interlock("a fault").after_goal(FIRST).after_goal(SECOND).after_goal(FIRST)
    assert not lock.is_new(FIRST, active=True)
    assert not lock.is_new(SECOND, active=True)


@given(st.lists(st.one_of(st.text(min_size=1), st.binary(min_size=16, max_size=16))))
@settings(derandomize=True, deadline=None)
def test_only_resume_frees(events):
    lock = Interlock().held("a fault")
    for event in events:
        lock = lock.held(event) if isinstance(event, str) else lock.after_goal(event)
        assert lock.reason
    assert not lock.resumed().reason
