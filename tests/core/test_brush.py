"""Who brushes the robot holds nobody up: moved a little it goes on slowly; moved more, or twice, it is held."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.control.brush import AGAIN, MOVED, RESTS, SLOWLY, TURNED, Brush, judge_brush
from collplan_core.control.motion_monitor import MotionRecord
from collplan_core.control.runaway import MOVES
from collplan_core.parameters import Settings
from collplan_core.state import State
from scenes import commanded, posed

SETTINGS, PERIOD, BEGINS = Settings(), 0.05, 2.0
WHY = "motion is turned or mirrored against the commands"


NEVER = Brush()


def brushed(moved, turned, lasts, bearing, gap=(math.inf, 0.0), before=NEVER) -> list[tuple[float, Brush]]:
    """Each period's time [s] and brush of a standing robot that is moved [m] and turned [rad] from BEGINS on."""
    record, brush, told, rows = MotionRecord(), before, False, []
    for k in range(round(100 * (BEGINS + lasts + 3.0))):
        now = 0.01 * k
        share, goes = float(np.clip((now - BEGINS) / lasts, 0.0, 1.0)), BEGINS < now < BEGINS + lasts
        along = moved * np.array([math.cos(bearing), math.sin(bearing)])
        if not gap[0] <= now < sum(gap):
            state = State(now, share * along, along / lasts if goes else np.zeros(2), share * turned)
            record = posed(record, state, now, False)
        if k % round(100 * PERIOD) == 0:
            record = commanded(record, np.zeros(2), now)
            why = WHY if goes and not told else ""
            told = told or bool(why)
            brush = judge_brush(brush, why, record, now, SETTINGS)
            rows.append((now, brush))
    return rows


PUSHES = {"lasts": st.floats(0.1, 0.9), "bearing": st.floats(-math.pi, math.pi)}


@given(moved=st.floats(0.0, 0.98 * MOVED), turned=st.floats(-0.98 * TURNED, 0.98 * TURNED), **PUSHES)
@settings(max_examples=40, deadline=None)
def test_a_robot_that_is_moved_a_little_goes_on_after_a_rest_and_slowly_at_first(moved, turned, lasts, bearing):
    rows = brushed(moved, turned, lasts, bearing)
    assert not any(brush.held for _, brush in rows)
    stood, newest = [now for now, brush in rows if brush.why], rows[-1][1]
    moves = moved / lasts > 1.1 * MOVES
    assert stood[-1] >= BEGINS + (lasts if moves else 0.0) + RESTS - 2.0 * PERIOD
    assert newest.why == ""
    x, y = newest.went_on
    assert newest.is_fresh(x + 0.99 * SLOWLY, y)
    assert not newest.is_fresh(x, y - 1.01 * SLOWLY)


@given(moved=st.floats(1.05 * MOVED, 2.0), turned=st.floats(1.05 * TURNED, 3.0), by=st.booleans(), **PUSHES)
@settings(max_examples=40, deadline=None)
def test_who_moves_or_turns_it_further_has_to_let_it_go_on(moved, turned, by, lasts, bearing):
    rows = brushed(moved if by else 0.0, 0.0 if by else turned, lasts, bearing)
    assert rows[-1][1].held == WHY


@pytest.mark.parametrize(
    ("push", "held"),
    [
        ({"before": Brush(begun=BEGINS - AGAIN + 1.0)}, True),
        ({"before": Brush(begun=BEGINS - AGAIN - 1.0)}, False),
        ({"gap": (BEGINS + 0.2, 0.1)}, False),
        ({"gap": (BEGINS + 0.2, 0.3)}, True),
        ({"gap": (BEGINS - 0.4, 0.3)}, True),
    ],
)
def test_twice_within_a_time_or_with_poses_missing_it_is_held(push, held):
    assert bool(brushed(0.05, 0.0, 0.3, 0.5, **push)[-1][1].held) == held
