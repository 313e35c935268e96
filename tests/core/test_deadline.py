"""A deadline that a clock has decided can be met again without the clock."""

from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.deadline import CountedDeadline, after_looks, never

FEW = settings(derandomize=True, deadline=None, max_examples=60)


@given(st.lists(st.booleans(), max_size=20))
@FEW
def test_what_a_deadline_answered_is_answered_again(answers):
    told = iter(answers)
    counted = CountedDeadline(lambda: next(told))
    heard = [counted() for _ in answers]
    again = after_looks(counted.looks) if counted.came else never
    assert [again() for _ in answers] == heard
    # it comes at the first True, and then has come for good
    assert heard == [any(answers[: k + 1]) for k in range(len(answers))]
    assert (counted.looks, counted.came) == (sum(not each for each in heard), any(answers))
