"""What the controller does, as it goes out: in words, and a warning for a stop on the way."""

import itertools

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus

from collplan_core.command import BOUNDARY_FOLLOWING, FREE_SPACE, HAND, MANEUVERS, STOPPED, WAITING, Command
from collplan_ros.messages.states import command_in_words, command_to_state


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
    for given, slowed, words in table:
        assert command_in_words(given, slowed) == words


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
