"""Spring and damper of a compliant ring: a hit that is integrated lasts as long and gives back as much as asked."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnipuck_sim.robot.compliant_ring import LEAST_RESTITUTION, MOST_RESTITUTION, spring_and_damper


def hit(stiffness: float, damping: float, step: float) -> tuple[float, float]:
    """Restitution and contact time [s] of a mass that hits at 1 m/s, until nothing pushes it any more."""
    depth, speed, time = 0.0, 1.0, 0.0
    while stiffness * depth + damping * speed > 0.0:
        speed -= (stiffness * depth + damping * speed) * step
        depth += speed * step
        time += step
    return -speed, time


@settings(derandomize=True, deadline=None, max_examples=30)
@given(st.floats(0.005, 0.1), st.floats(LEAST_RESTITUTION, MOST_RESTITUTION))
def test_a_hit_lasts_as_long_and_gives_back_as_much_as_asked(contact_time, restitution):
    found, lasted = hit(*spring_and_damper(contact_time, restitution), contact_time / 20000)
    assert found == pytest.approx(restitution, abs=2e-3)
    assert lasted == pytest.approx(contact_time, rel=2e-3)


@pytest.mark.parametrize("restitution", [-0.5, 0.0, 1.0, 1.5])
def test_restitutions_that_no_ring_has_are_taken_as_the_nearest(restitution):
    nearest = min(max(restitution, LEAST_RESTITUTION), MOST_RESTITUTION)
    assert spring_and_damper(0.015, restitution) == spring_and_damper(0.015, nearest)
