"""Commands of a page: the token first, then what is asked for; nothing else gets any further. And how many may come."""

import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_ros.view.allowance import Allowance
from collplan_ros.view.commands import ACTIONS, CommandError, PageCommand, WrongToken, command_from_text, number_of

QUICK = settings(derandomize=True, deadline=None, max_examples=50)
TOKEN = "the-token"
ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)
SET = {"do": "set", "node": "/a", "name": "b"}


def text_of(**given):
    return json.dumps({"token": TOKEN, "number": 1, **given})


def test_what_may_be_asked_for():
    for given_, expected in (
        ({"do": "goal", "x": 1, "y": -2.5}, PageCommand(1, "goal", at=(1.0, -2.5))),
        ({"do": "estop"}, PageCommand(1, "estop")),
        ({"do": "cancel", "number": 0}, PageCommand(0, "cancel")),
        ({"do": "resume", "extra": [1]}, PageCommand(1, "resume")),
        ({"do": "clear_estop"}, PageCommand(1, "clear_estop")),
        ({**SET, "value": "bounce"}, PageCommand(1, "set", node="/a", name="b", value="bounce")),
        ({**SET, "value": [1, 2.5]}, PageCommand(1, "set", node="/a", name="b", value=(1.0, 2.5))),
        ({**SET, "value": False}, PageCommand(1, "set", node="/a", name="b", value=False)),
    ):
        assert command_from_text(text_of(**given_), TOKEN) == expected


def test_what_may_not():
    for given_, key in (
        ({"do": "goal", "x": math.nan, "y": 0}, "x: got nan"),
        ({"do": "goal", "x": math.inf, "y": 0}, "x: got inf"),
        ({"do": "goal", "x": "1", "y": 0}, "x: got '1'"),
        ({"do": "goal", "x": True, "y": 0}, "x: got True"),
        ({"do": "goal", "x": 10**300, "y": 0}, "x: got 1000"),
        ({"do": "goal", "x": 1}, "y: got None"),
        ({"do": "shutdown"}, "do: got 'shutdown'"),
        ({}, "do: got None"),
        ({"do": "estop", "number": "1"}, "number: got '1'"),
        ({"do": "estop", "number": -1}, "number: got -1"),
        ({"do": "estop", "number": True}, "number: got True"),
        ({**SET, "node": "", "value": 1}, "node: got ''"),
        ({**SET, "name": ["b"], "value": 1}, "name: got"),
        ({**SET, "name": "b" * 500, "value": 1}, "name: got"),
        ({**SET, "value": {}}, "value: got {}"),
        ({**SET, "value": [math.nan]}, "value: got"),
        (SET, "value: got None"),
    ):
        with pytest.raises(CommandError) as error:
            command_from_text(text_of(**given_), TOKEN)
        assert str(error.value).startswith(key)
        assert isinstance(number_of(text_of(**given_)), int)


def test_without_the_token_nothing_is_read():
    for text in (
        "", "{", "null", "[]", "1", '"the-token"', b"\xff\xfe", "[" * 3000, json.dumps({"do": "estop", "number": 1}),
        json.dumps({"token": "the-tokem", "do": "estop", "number": 1}), json.dumps({"token": None, "do": "estop"}),
        json.dumps({"token": [TOKEN], "do": "estop"}), '{"token": "\\ud800", "do": "estop"}', "1" * 4000,
    ):  # fmt: skip
        with pytest.raises(WrongToken):
            command_from_text(text, TOKEN)


@QUICK
@given(
    ANYTHING | st.dictionaries(st.sampled_from(["number", "do", "x", "y", "node", "name", "value"]), ANYTHING),
    st.booleans(),
)
def test_whatever_comes_is_a_command_or_refused_in_words(anything, has_token):
    if has_token and isinstance(anything, dict):
        anything = {**anything, "token": TOKEN}
    try:
        command = command_from_text(json.dumps(anything), TOKEN)
    except WrongToken:
        assert not (isinstance(anything, dict) and anything.get("token") == TOKEN)
        return
    except CommandError as error:
        words = str(error)
    else:
        assert command.action in ACTIONS
        assert all(math.isfinite(value) for value in command.at)
        return
    assert "expected" in words


@QUICK
@given(st.lists(st.tuples(st.floats(0.0, 1.0), st.integers(1, 3)), max_size=50))
def test_no_more_is_allowed_than_the_most_and_what_the_rate_adds(steps):
    allowance, now, allowed = Allowance(10.0, 5.0), 0.0, 0.0
    for wait, amount in steps:
        now += wait
        if not allowance.spend(amount, now):
            break
        allowed += amount
        assert allowed <= 10.0 + 5.0 * now + 1e-9


def test_an_allowance_fills_up_again():
    allowance = Allowance(2.0, 1.0)
    assert [allowance.spend(1.0, 0.0) for _ in range(3)] == [True, True, False]
    assert allowance.spend(1.0, 3.0)
    assert not allowance.spend(5.0, 100.0)
