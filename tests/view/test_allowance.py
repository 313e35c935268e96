"""How much may come in a time."""

from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_ros.view.allowance import Allowance

QUICK = settings(derandomize=True, deadline=None, max_examples=100)


@QUICK
@given(st.lists(st.tuples(st.floats(0.0, 1.0), st.integers(1, 3)), max_size=50))
def test_no_more_than_the_most_and_what_the_rate_adds(steps):
    allowance, now, allowed = Allowance(10.0, 5.0), 0.0, 0.0
    for wait, amount in steps:
        now += wait
        if not allowance.spend(amount, now):
            break
        allowed += amount
        assert allowed <= 10.0 + 5.0 * now + 1e-9


def test_it_fills_up_again():
    allowance = Allowance(2.0, 1.0)
    assert [allowance.spend(1.0, 0.0) for _ in range(3)] == [True, True, False]
    assert allowance.spend(1.0, 3.0)
    assert not allowance.spend(5.0, 100.0)
