"""A journal: what it holds comes back bit for bit, and whatever changes in it or is missing is noticed."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.deadline import CountedDeadline, after_looks, never
from collplan_core.goal import Goal
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.plan import plan_of_path
from collplan_core.replay.comparison import Difference, Interruption, compare
from collplan_core.replay.journal import CONTROLLER, PLANNER, Journal
from collplan_core.replay.reading import Call, events_of, rows_of
from collplan_core.replay.values import JournalError, decode, encode
from collplan_core.scan import Scan
from loop_scenes import AHEAD, IDENTITY, SETTINGS, at, cycles, scan_at

BOUNCE = SETTINGS.with_values({"planner.strategy": "bounce", "time_to_goal.proposals": 3000})


def written() -> list[str]:
    lines = []
    planner_journal, controller_journal = (Journal(of, lines.append) for of in (PLANNER, CONTROLLER))
    planner_journal.begin(BOUNCE)
    controller_journal.begin(BOUNCE)
    forbidden = {0.35: "nodes disagree"}
    deadlines = planner_journal.count_checks(lambda settings: after_looks(1))
    now = [0.0]
    why = planner_journal.record_answers(lambda: forbidden.get(now[0], ""))
    planner, controller = PlannerLoop(BOUNCE, deadlines, None, why), ControllerLoop(BOUNCE)
    to_planner, to_controller = planner_journal.call, controller_journal.call

    def pass_on(decisions) -> None:
        for decision in decisions:
            if isinstance(decision, Goal):
                to_controller(controller.take_goal, decision)
        for cycle in cycles(decisions):
            to_controller(controller.take_plan, cycle.plan, now[0])

    for k in range(1, 60):
        now[0] = round(0.01 * k, 2)
        state = at(now[0], 0.002 * k)
        pass_on(to_planner(planner.take_pose, state, now[0]))
        to_controller(controller.take_pose, state, now[0])
        if k % 5 == 0:
            to_planner(planner.take_scan, scan_at(state), now[0])
            to_controller(controller.take_scan, scan_at(state), now[0])
            pass_on(to_planner(planner.cycle, now[0]))
            to_controller(controller.tick, now[0])
            planner_journal.end_cycle()
            controller_journal.end_cycle()
        if k == 7:
            pass_on(to_planner(planner.take_goal, IDENTITY, AHEAD, now[0]))
    return lines


@pytest.fixture(scope="module")
def lines():
    return tuple(written())


def compared(lines, of):
    rows = rows_of(lines, "a file")
    return list(compare(of, events_of(rows, of)))


def changed(lines, number: int, of: str, change) -> list[str]:
    """The lines with a change of one of them; left out where that returns None."""
    rows = [json.loads(line) for line in lines]
    new = [change(row) if (row["number"], row["of"]) == (number, of) else row for row in rows]
    return [json.dumps(row) for row in new if row is not None]


def test_what_was_written_is_played_to_the_last_bit(lines):
    beginning = next(events_of(rows_of(lines, ""), PLANNER))
    assert (beginning.settings, beginning.made_with["numpy"]) == (BOUNCE, np.__version__)
    (planner,), (controller,) = compared(lines, PLANNER), compared(lines, CONTROLLER)
    assert (planner.end, controller.end) == (None, None)
    assert planner.plans >= 8
    assert controller.commands == 11
    assert planner.calls == 78  # 55 poses, 11 scans, 11 cycles, a goal


def test_a_drive_by_hand_is_played_to_the_last_bit():
    lines = []
    journal, loop = Journal(CONTROLLER, lines.append), ControllerLoop(SETTINGS)
    journal.begin(SETTINGS)
    for k in range(1, 8):
        journal.call(loop.take_robot_state, "just started" if k < 3 else "")
        velocity = np.array([0.3 / k, np.nan if k == 6 else 0.1])
        journal.call(loop.take_manual_command, velocity, 0.1 * k, 0.05 * k - 0.01, "two of them" if k == 4 else "")
        journal.call(loop.tick, 0.05 * k)
        journal.end_cycle()
    (played,) = compared(lines, CONTROLLER)
    assert (played.end, played.commands) == (None, 7)


def test_what_the_loop_was_told_is_told_again(lines):
    calls = [call for call in events_of(rows_of(lines, ""), PLANNER) if isinstance(call, Call)]
    assert [call.forbidden for call in calls if call.forbidden] == [("nodes disagree",)]
    assert {call.deadline_checks for call in calls if call.deadline_checks} == {(1,)}

    for key, number, stamp in (("forbidden", 7, 0.35), ("deadline_checks", 9, 0.45)):

        def without(row, key=key):
            return {**row, "calls": [{k: v for k, v in call.items() if k != key} for call in row["calls"]]}

        # and it makes a difference
        (planner,) = compared(changed(lines, number, PLANNER, without), PLANNER)
        assert isinstance(planner.end, Difference)
        assert planner.end.stamp == pytest.approx(stamp)


def test_a_missing_line_is_a_gap_of_its_own_loop(lines):
    for of in (PLANNER, CONTROLLER):
        (found,), (whole,) = compared(changed(lines, 6, of, lambda row: None), of), compared(lines, of)
        assert isinstance(found.end, Interruption)
        assert "0.250" in str(found.end)
        assert 0 < found.calls < whole.calls
    (found,) = compared(changed(lines, 6, CONTROLLER, lambda row: None), PLANNER)
    assert found.end is None
    rows = [line for line in lines if json.loads(line)["of"] == PLANNER]
    twice, swapped = [*rows[:4], rows[3], *rows[4:]], [*rows[:4], rows[5], rows[4], *rows[6:]]
    for odd, words in ((rows[3:], "line 3"), (twice, "line 4"), (swapped, "line 5")):
        (found,) = compared(odd, PLANNER)
        assert isinstance(found.end, Interruption)
        assert words in str(found.end)


def test_a_node_that_was_started_again_is_compared_from_its_start(lines):
    first, second = compared([*lines, *lines], PLANNER)
    assert (first.end, second.end) == (None, None)
    assert first.plans == second.plans


def test_a_last_line_that_was_cut_off_is_left_out(lines):
    rows = rows_of([*lines[:-1], lines[-1][:50]], "a file")
    assert len(rows) == len(lines) - 1
    with pytest.raises(JournalError, match="a file: line 3"):
        rows_of([*lines[:2], "{", *lines[3:]], "a file")


def test_a_line_of_another_format_or_that_holds_no_calls_is_refused(lines):
    unknown = {"calls": [{"call": "__init__", "args": []}]}
    for odd in ({"calls": 3}, {"calls": [{"call": "tick", "args": [{"x": 1}]}]}, {}, unknown, {"format": 9}):
        number = 0 if "format" in odd else 2
        with pytest.raises(JournalError):
            compared(changed(lines, number, PLANNER, lambda row, odd=odd: {**row, "calls": None, **odd}), PLANNER)


def test_the_first_outcome_that_differs_is_shown_in_time_and_value(lines):
    def other_sign(row):
        calls = [call for call in row["calls"] if "command" in (call.get("result") or ())]
        for call in calls:
            call["result"]["command"]["yaw_rate"] *= -1.0
        return row

    (found,) = compared(changed(lines, 4, CONTROLLER, other_sign), CONTROLLER)
    assert isinstance(found.end, Difference)
    assert found.end.stamp == pytest.approx(0.20)
    assert all(part in str(found.end) for part in ("at 0.200 s", "command.yaw_rate", "-0.0"))


anything = st.floats()
arrays = st.lists(anything, min_size=1, max_size=8).map(np.array)


def back(value):
    return decode(json.loads(json.dumps(encode(value))))


def bits(*values) -> bytes:
    """The bits of numbers and arrays; every NaN is the same."""
    flat = np.concatenate([np.ravel(value) for value in values]).astype(float)
    return np.where(np.isnan(flat), np.nan, flat).tobytes()


@given(arrays)
def test_an_array_survives_with_its_shape(array):
    for shaped in (array, array.reshape(-1, 1), np.tile(array, (2, 1)).T):
        found = back(shaped)
        assert (found.shape, found.dtype) == (shaped.shape, np.float64)
        assert bits(found) == bits(shaped)
        found[0] = 1.0  # it can be written to, as an array of a message can
    goal = back(Goal(bytes(range(16)), array[0], array, "status"))
    assert (goal.id, goal.status, bits(goal.stamp)) == (bytes(range(16)), "status", bits(array[0]))


@given(st.lists(st.one_of(st.floats(0.02, 12.0), st.just(math.nan), st.just(math.inf)), min_size=2, max_size=20))
def test_a_scan_and_a_plan_survive(ranges):
    scan = Scan(1.0, -3.0, 0.1, 0.02, 12.0, np.array([1.0, *ranges]), 1e-4)
    found = back(scan)
    assert isinstance(found, Scan)
    assert bits(found.ranges) == bits(scan.ranges)
    assert (found.stamp, found.angle_min, found.time_increment) == (1.0, -3.0, 1e-4)
    assert not found.ranges.flags.writeable
    positions = np.column_stack([ranges, ranges])
    plan = plan_of_path(1.0, 1.0 + 0.1 * np.arange(len(ranges)), positions, 0.5 * positions)
    found = back(plan)
    assert (found.stamp, bits(found.positions, found.velocities)) == (1.0, bits(positions, 0.5 * positions))


@given(st.lists(st.booleans(), max_size=20))
def test_what_a_deadline_answered_is_answered_again(answers):
    told = iter(answers)
    counted = CountedDeadline(lambda: next(told))
    heard = [counted() for _ in answers]
    again = after_looks(counted.looks) if counted.came else never
    assert [again() for _ in answers] == heard
    # it comes at the first True, and then has come for good
    assert heard == [any(answers[: k + 1]) for k in range(len(answers))]
    assert (counted.looks, counted.came) == (sum(not each for each in heard), any(answers))
