"""A journal as it is written and read: in order, with what the loop was told, and gaps are noticed."""

import json
from dataclasses import replace

import numpy as np
import pytest

from collplan_core.deadline import after_looks
from collplan_core.goal import Goal
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.replay.comparison import Difference, Interruption, compare
from collplan_core.replay.contents import content_of, reference_to, value_of
from collplan_core.replay.journal import CONTROLLER, PLANNER, Journal, each_once, first_scans
from collplan_core.replay.reading import Beginning, Call, contents_of, events_of, rows_of
from collplan_core.replay.values import JournalError
from loop_scenes import AHEAD, IDENTITY, SETTINGS, at, cycles, scan_at, straight_plan

BOUNCE = SETTINGS.with_values({"planner.strategy": "bounce", "time_to_goal.proposals": 3000})


class Robot:
    """Called by its journal alone."""

    def __init__(self, journal: Journal) -> None:
        self.calls = []
        self._forbidden = journal.asked(lambda: "too dark" if len(self.calls) == 2 else "")

    def go(self, *given):
        self.calls.append(given)
        return self._forbidden()

    def fall(self):
        raise ZeroDivisionError("over a stone")


def written(carries) -> list[str]:
    """The lines of the journals of planner and controller that drive for a few cycles towards a goal."""
    lines = []
    planner_journal, controller_journal = (Journal(of, lines.append, carries) for of in (PLANNER, CONTROLLER))
    planner_journal.begin(BOUNCE)
    controller_journal.begin(BOUNCE)
    forbidden = {0.35: "nodes disagree"}
    deadlines = planner_journal.counted(lambda settings: after_looks(7))
    now = [0.0]
    why = planner_journal.asked(lambda: forbidden.get(now[0], ""))
    planner, controller = PlannerLoop(BOUNCE, deadlines, None, why), ControllerLoop(BOUNCE)
    to_planner, to_controller = planner_journal.call, controller_journal.call

    def pass_on(decisions) -> None:
        for decision in decisions:
            if isinstance(decision, Goal):
                to_controller(controller.take_goal, decision)
        for cycle in cycles(decisions):
            to_controller(controller.take_valid_until, cycle.plan.stamp, cycle.valid_until)
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
    return tuple(written(each_once()))


def compared(lines, of):
    rows = rows_of(lines, "a file")
    return list(compare(of, events_of(rows, of), contents_of(rows)))


def changed(lines, number: int, of: str, change) -> list[str]:
    """The lines with a change of one of them; left out where that returns None."""
    rows = [json.loads(line) for line in lines]
    new = [change(row) if (row["number"], row["of"]) == (number, of) else row for row in rows]
    return [json.dumps(row) for row in new if row is not None]


def test_what_was_written_is_played_to_the_last_bit(lines):
    (planner,), (controller,) = compared(lines, PLANNER), compared(lines, CONTROLLER)
    assert (planner.end, controller.end) == (None, None)
    assert planner.plans >= 8
    assert controller.commands == 11
    assert planner.calls == 78  # 55 poses, 11 scans, 11 cycles, a goal


def test_a_drive_by_hand_is_played_to_the_last_bit():
    lines = []
    journal, loop = Journal(CONTROLLER, lines.append), ControllerLoop(SETTINGS)
    journal.begin(SETTINGS)
    for k in range(1, 13):
        now = 0.05 * k
        journal.call(loop.take_robot_state, "just started" if k < 3 else "")
        if k < 7:
            velocity = np.array([0.3 / k, np.nan if k == 6 else 0.1])
            journal.call(loop.take_hand, velocity, 0.1 * k, now - 0.01, "two of them" if k == 4 else "")
        journal.call(loop.tick, now)
        journal.end_cycle()
    (played,) = compared(lines, CONTROLLER)
    assert (played.end, played.commands) == (None, 12)

    def alone(row):
        return {**row, "calls": [call for call in row["calls"] if call["call"] != "take_hand"]}

    (other,) = compared(changed(lines, 3, CONTROLLER, alone), CONTROLLER)
    assert isinstance(other.end, Difference)


def test_what_the_loop_was_told_is_told_again(lines):
    calls = [call for call in events_of(rows_of(lines, ""), PLANNER) if isinstance(call, Call)]
    assert [call.forbidden for call in calls if call.forbidden] == [("nodes disagree",)]
    assert {call.looks for call in calls if call.looks} == {(7,)}

    def without(row):
        return {**row, "calls": [{k: v for k, v in call.items() if k != "forbidden"} for call in row["calls"]]}

    # and it makes a difference
    (planner,) = compared(changed(lines, 7, PLANNER, without), PLANNER)
    assert isinstance(planner.end, Difference)
    assert planner.end.stamp == 0.35


@pytest.mark.parametrize("of", [PLANNER, CONTROLLER])
def test_a_missing_line_is_a_gap(lines, of):
    (found,) = compared(changed(lines, 6, of, lambda row: None), of)
    assert isinstance(found.end, Interruption)
    assert str(found.end) == "a gap after 0.250 s: 1 line is missing before line 7 of the journal"
    (whole,) = compared(lines, of)
    assert 0 < found.calls < whole.calls


def test_a_gap_of_one_loop_is_none_of_the_other(lines):
    (planner,) = compared(changed(lines, 6, CONTROLLER, lambda row: None), PLANNER)
    assert planner.end is None


def test_a_missing_beginning_is_a_gap(lines):
    (found,) = compared([line for line in lines if json.loads(line)["number"] >= 3], PLANNER)
    assert str(found.end) == "a gap before the first pose: 3 lines are missing before line 3 of the journal"
    assert found.calls == 0


def test_lines_twice_or_in_the_wrong_order_are_a_gap(lines):
    rows = [line for line in lines if json.loads(line)["of"] == PLANNER]
    twice, swapped = [*rows[:4], rows[3], *rows[4:]], [*rows[:4], rows[5], rows[4], *rows[6:]]
    for odd, words in ((twice, "line 3 comes where line 4 was due"), (swapped, "1 line is missing before line 5")):
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
    with pytest.raises(JournalError, match="a file: line 3: not JSON"):
        rows_of([*lines[:2], "{", *lines[3:]], "a file")


def test_a_journal_of_another_format_is_refused(lines):
    with pytest.raises(JournalError, match="format: got 9, expected 1"):
        compared(changed(lines, 0, PLANNER, lambda row: {**row, "format": 9}), PLANNER)


@pytest.mark.parametrize("odd", [{"calls": 3}, {"calls": [{}]}, {"calls": [{"call": "tick", "given": [{"x": 1}]}]}, {}])
def test_a_line_that_holds_no_calls_is_refused(lines, odd):
    with pytest.raises(JournalError):
        compared(changed(lines, 2, PLANNER, lambda row: {"number": 2, "of": PLANNER, **odd}), PLANNER)


def test_a_call_that_the_loop_does_not_know_is_refused(lines):
    row = {"number": 2, "of": PLANNER, "calls": [{"call": "__init__", "given": []}]}
    with pytest.raises(JournalError, match="got '__init__', expected one of change_settings"):
        compared(changed(lines, 2, PLANNER, lambda _: row), PLANNER)


# ---- writing


def test_calls_are_passed_on_and_what_comes_of_them_too():
    lines = []
    journal = Journal(PLANNER, lines.append)
    robot = Robot(journal)
    assert [journal.call(robot.go, k, "there") for k in range(3)] == ["", "too dark", ""]
    assert robot.calls == [(0, "there"), (1, "there"), (2, "there")]
    journal.end_cycle()
    journal.end_cycle()
    (row,) = map(json.loads, lines)
    assert [call.get("forbidden") for call in row["calls"]] == [None, ["too dark"], None]
    assert [call.get("came") for call in row["calls"]] == [None, "too dark", None]


def test_an_error_is_raised_and_kept():
    lines = []
    journal = Journal(PLANNER, lines.append)
    with pytest.raises(ZeroDivisionError):
        journal.call(Robot(journal).fall)
    journal.end_cycle()
    assert json.loads(lines[0])["calls"] == [
        {"call": "fall", "given": [], "came": {"raised": "ZeroDivisionError: over a stone"}}
    ]


def test_an_answer_that_no_call_asked_for_is_not_kept():
    lines = []
    journal = Journal(PLANNER, lines.append)
    assert journal.asked(lambda: "always")() == "always"
    journal.end_cycle()
    assert lines == []


def test_without_a_listener_nothing_is_kept():
    journal = Journal(PLANNER)
    journal.begin(SETTINGS)
    loop = PlannerLoop(SETTINGS, journal.counted(lambda settings: after_looks(0)))
    journal.call(loop.take_pose, at(1.0), 1.0)
    journal.end_cycle()
    assert journal._calls == []
    assert loop._sensors.state.stamp == 1.0


def test_each_scan_is_written_out_once_or_the_first_ones_only():
    for carries, expected in ((each_once(), [1, 0, 1]), (first_scans(1), [1, 0, 0])):
        lines = []
        journal = Journal(PLANNER, lines.append, carries)
        loop = PlannerLoop(SETTINGS, lambda settings: after_looks(0))
        for stamp in (1.0, 1.0, 2.0):
            journal.call(loop.take_scan, scan_at(at(stamp)), stamp)
            journal.end_cycle()
        assert [len(json.loads(line).get("contents", ())) for line in lines] == expected


def test_plans_are_not_among_the_first_scans():
    carries = first_scans(1)
    assert not carries(reference_to(straight_plan(1.0)))
    assert carries(reference_to(scan_at(at(1.0))))


def test_a_scan_that_was_recorded_nowhere_is_a_gap():
    lines = written(lambda reference: False)
    (found,) = compared(lines, PLANNER)
    assert isinstance(found.end, Interruption)
    assert str(found.end) == "a gap after 0.050 s: the scan of stamp 0.050000 that was taken is not in the recording"


# ---- differences


def test_a_zero_of_the_other_sign_is_a_difference(lines):
    said = _first_change(lines, CONTROLLER, "command", lambda command: {**command, "yaw_rate": -command["yaw_rate"]})
    assert said in ("yaw_rate: -0.0 recorded, 0.0 replayed", "yaw_rate: 0.0 recorded, -0.0 replayed")


def test_the_first_difference_is_shown_in_time_and_value(lines):
    def later(plan):
        return {**plan, "valid_until": plan["valid_until"] + 1e-9}

    said = _first_change(lines, PLANNER, "plan", later)
    assert said.startswith("valid_until: ")


def _first_change(lines, of, kind, change) -> str:
    """What is said of a change in the outcomes of a kind from line 4 on, after the words that say where."""

    def outcome(came):
        if isinstance(came, list):
            return [outcome(each) for each in came]
        return {kind: change(came[kind])} if isinstance(came, dict) and kind in came else came

    rows = [json.loads(line) for line in lines]
    for row in rows:
        if row["of"] == of and row["number"] >= 4:
            row["calls"] = [{**call, "came": outcome(call.get("came"))} for call in row["calls"]]
    (found,) = compared([json.dumps(row) for row in rows], of)
    assert isinstance(found.end, Difference)
    assert found.end.stamp == pytest.approx(0.20)
    at_time, _, where = str(found.end).partition(f"{kind}.")
    assert at_time.startswith("at 0.200 s: ")
    return where


def test_a_path_that_differs_is_told_by_its_first_place(lines):
    """Where the plan itself was recorded, as in a trial."""

    def elsewhere(content):
        plan = value_of(content)
        positions = getattr(plan, "positions", np.zeros((0, 2))).copy()
        positions[2:, 1] += 1e-9
        return content_of(replace(plan, positions=positions)) if "plan" in content else content

    def of_another_path(call):
        came = call.get("came")
        if call["call"] != "cycle" or came is None:
            return call
        return {**call, "came": [{"plan": {**each["plan"], "path": ""}} if "plan" in each else each for each in came]}

    rows = rows_of(lines, "")
    for row in rows[2:]:
        row["calls"] = [of_another_path(call) for call in row["calls"]]
        row["contents"] = [elsewhere(content) for content in row.get("contents", ())]
    (found,) = compare(PLANNER, events_of(rows, PLANNER), contents_of(rows))
    assert isinstance(found.end, Difference)
    assert found.end.where == "cycle[2].plan.positions[2]"
    assert found.end.recorded[0] == found.end.replayed[0]
    assert found.end.recorded[1] == pytest.approx(found.end.replayed[1] + 1e-9, abs=1e-15)


def test_a_beginning_says_what_the_journal_was_made_with(lines):
    beginning = next(events_of(rows_of(lines, ""), PLANNER))
    assert isinstance(beginning, Beginning)
    assert beginning.settings == BOUNCE
    assert beginning.made_with["numpy"] == np.__version__
