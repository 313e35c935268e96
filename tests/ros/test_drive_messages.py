"""The learnt drive in messages, bit for bit, as planner and controller must not differ; what the controller does."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.command import BOUNDARY_FOLLOWING, FREE_SPACE, HAND, MANEUVERS, STOPPED, WAITING, Command
from collplan_core.learning.drive import Drive, Learnt, LearntDrive
from collplan_core.plan import timed_path
from collplan_core.replay.values import decode, encode
from collplan_ros.messages.cloud_reading import plan_from_message
from collplan_ros.messages.planner_clouds import plan_to_message
from collplan_ros.messages.reading import MessageError
from collplan_ros.messages.states import command_in_words, command_to_state, drive_to_message
from collplan_ros.messages.status_values import DRIVE, drive_figures

DRIVES = st.builds(Drive, st.floats(0.1, 20.0), st.floats(0.0, 1.0), st.floats(0.0, 0.3))
BELIEF = Drive(1.5, 0.1, 0.0)
LEARNT = LearntDrive(Learnt(0.74, 0.73, 0.75, 1.0), Learnt(0.2, 0.17, 0.24, 1.0), Learnt(0.0, 0.0, 0.01, 1.0))
PLAN = timed_path(1.0, [1.0, 2.0], [[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [1.0, 0.0]], valid_until=1.5)


@given(drive=DRIVES)
def test_a_plan_and_a_message_carry_the_drive_as_it_is(drive):
    sent = plan_from_message(plan_to_message(replace(PLAN, drive=drive), "map"), "map")
    assert (sent.drive, sent.valid_until, sent.times.tolist()) == (drive, 1.5, [1.0, 2.0])
    figures = drive_figures(drive_to_message(drive, LEARNT, BELIEF, "/controller_node"))
    assert tuple(figures[name] for name in DRIVE) == drive
    assert tuple(decode(encode(replace(PLAN, drive=drive))).drive) == drive


def test_before_anything_is_learnt_it_tells_what_is_in_use():
    message = drive_to_message(BELIEF, None, BELIEF, "/c")
    assert (message.level, drive_figures(message)) == (DiagnosticStatus.OK, dict(zip(DRIVE, BELIEF, strict=True)))
    assert "not learnt yet" in message.message


def test_a_plan_without_one_is_as_before():
    assert plan_from_message(plan_to_message(PLAN, "map"), "map").drive is None
    assert "drive" not in encode(PLAN)["plan"]


def test_a_drive_that_is_not_what_is_set_is_a_warning():
    warned, fine = (drive_to_message(BELIEF, LEARNT, belief, "/c") for belief in (BELIEF, Drive(0.75, 0.2, 0.0)))
    assert (warned.level, warned.message) == (
        DiagnosticStatus.WARN,
        "drives like 0.74 m/s^2, set to 1.5; with a lag of 0.20 s, set to 0.1",
    )
    assert fine.level == DiagnosticStatus.OK
    assert fine.message.startswith("drives like 0.74 m/s^2 (0.73 to 0.75), with a lag of 0.20 s")


@pytest.mark.parametrize(
    "values", [{"max_acceleration": "1.5"}, dict.fromkeys(DRIVE, "nan"), dict.fromkeys(DRIVE, "x")]
)
def test_figures_that_are_none_are_refused(values):
    message = DiagnosticStatus(values=[KeyValue(key=key, value=value) for key, value in values.items()])
    with pytest.raises(MessageError):
        drive_figures(message)
    with pytest.raises(MessageError):
        plan_from_message(plan_to_message(replace(PLAN, drive=(np.nan, 0.1, 0.0)), "map"), "map")


def command(maneuver, reason="") -> Command:
    return Command(np.zeros(2), 0.0, maneuver, np.zeros(2), reason)


def test_by_hand_each_command_in_words():
    table = [
        (command(FREE_SPACE), "", "free space"),
        (command(BOUNDARY_FOLLOWING), "", "boundary following"),
        (command(FREE_SPACE, "keeps off a mover"), "", "free space, slowly: keeps off a mover"),
        (command(HAND), "", "driven by hand"),
        (command(HAND), "no scan", "driven by hand, slowly: no scan"),
        (command(STOPPED, "no plan yet"), "", "stands still: no plan yet"),
        (command(WAITING, "a mover"), "", "stands still: a mover"),
    ]
    for done, slowed, words in table:
        assert command_in_words(done, slowed) == words


def test_the_message_says_what_why_and_by_which_plan():
    message = command_to_state(command(FREE_SPACE), "free space", 1.7e9 + 0.25, True, "/puck/controller_node")
    assert (message.name, message.message) == ("/puck/controller_node", "free space")
    assert {each.key: each.value for each in message.values} == {
        "maneuver": FREE_SPACE,
        "reason": "free space",
        "plan_stamp": "1700000000.250000000",
    }
    for is_to_move, maneuver in itertools.product((False, True), (*MANEUVERS, HAND, WAITING)):
        message = command_to_state(command(maneuver), "why", None, is_to_move, "/controller_node")
        assert (message.level == DiagnosticStatus.WARN) == (is_to_move and maneuver in (STOPPED, WAITING)), maneuver
        assert message.values[-1].value == "none"
