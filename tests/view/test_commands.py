"""Commands of a page: the token first, then what is asked for; nothing else gets any further."""

import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_ros.view.commands import ACTIONS, Command, CommandError, WrongToken, command_from_text, number_of

QUICK = settings(derandomize=True, deadline=None, max_examples=100)

TOKEN = "the-token"
ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)


def text_of(**given):
    return json.dumps({"token": TOKEN, "number": 1, **given})


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"do": "goal", "x": 1, "y": -2.5}, Command(1, "goal", at=(1.0, -2.5))),
        ({"do": "estop"}, Command(1, "estop")),
        ({"do": "cancel", "number": 0}, Command(0, "cancel")),
        ({"do": "resume", "extra": [1]}, Command(1, "resume")),
        ({"do": "clear_estop"}, Command(1, "clear_estop")),
        (
            {"do": "set", "node": "/planner_node", "name": "planner.strategy", "value": "bounce"},
            Command(1, "set", node="/planner_node", name="planner.strategy", value="bounce"),
        ),
        ({"do": "set", "node": "/a", "name": "b", "value": [1, 2.5]}, Command(1, "set", (0, 0), "/a", "b", (1.0, 2.5))),
        ({"do": "set", "node": "/a", "name": "b", "value": False}, Command(1, "set", (0, 0), "/a", "b", False)),
    ],
)
def test_what_may_be_asked_for(given, expected):
    assert command_from_text(text_of(**given), TOKEN) == expected


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"do": "goal", "x": math.nan, "y": 0}, "x: got nan, expected a number"),
        ({"do": "goal", "x": math.inf, "y": 0}, "x: got inf"),
        ({"do": "goal", "x": "1", "y": 0}, "x: got '1'"),
        ({"do": "goal", "x": True, "y": 0}, "x: got True"),
        ({"do": "goal", "x": 10**300, "y": 0}, "x: got 1000"),
        ({"do": "goal", "x": 1}, "y: got None"),
        ({"do": "shutdown"}, "do: got 'shutdown', expected one of goal, cancel"),
        ({}, "do: got None"),
        ({"do": "estop", "number": "1"}, "number: got '1'"),
        ({"do": "estop", "number": -1}, "number: got -1"),
        ({"do": "estop", "number": True}, "number: got True"),
        ({"do": "set", "node": "", "name": "b", "value": 1}, "node: got ''"),
        ({"do": "set", "node": "/a", "name": ["b"], "value": 1}, "name: got"),
        ({"do": "set", "node": "/a", "name": "b" * 500, "value": 1}, "name: got"),
        ({"do": "set", "node": "/a", "name": "b", "value": {}}, "value: got {}"),
        ({"do": "set", "node": "/a", "name": "b", "value": [math.nan]}, "value: got"),
        ({"do": "set", "node": "/a", "name": "b"}, "value: got None"),
    ],
)
def test_what_may_not(given, words):
    with pytest.raises(CommandError) as error:
        command_from_text(text_of(**given), TOKEN)
    assert str(error.value).startswith(words)
    assert isinstance(number_of(text_of(**given)), int)


@pytest.mark.parametrize(
    "text",
    [
        "", "{", "null", "[]", "1", '"the-token"', b"\xff\xfe", "[" * 3000, json.dumps({"do": "estop", "number": 1}),
        json.dumps({"token": "the-tokem", "do": "estop", "number": 1}), json.dumps({"token": None, "do": "estop"}),
        json.dumps({"token": [TOKEN], "do": "estop"}), '{"token": "\\ud800", "do": "estop"}', "1" * 4000,
    ],
)  # fmt: skip
def test_without_the_token_nothing_is_read(text):
    with pytest.raises(WrongToken):
        command_from_text(text, TOKEN)


@QUICK
@given(ANYTHING)
def test_whatever_comes_is_a_command_or_refused(anything):
    try:
        command = command_from_text(json.dumps(anything), TOKEN)
    except (WrongToken, CommandError):
        return
    assert command.action in ACTIONS


@QUICK
@given(st.dictionaries(st.sampled_from(["number", "do", "x", "y", "node", "name", "value"]), ANYTHING))
def test_whatever_comes_with_the_token_is_a_command_or_refused_in_words(anything):
    try:
        command = command_from_text(json.dumps({**anything, "token": TOKEN}), TOKEN)
    except CommandError as error:
        words = str(error)
    else:
        assert all(math.isfinite(value) for value in command.at)
        return
    assert "expected" in words
