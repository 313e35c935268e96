"""Commands of a page: the token first, then what is asked for; nothing else gets any further."""

import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_ros.view.requests import ACTIONS, CommandError, PageCommand, WrongToken, command_from_text, number_of

QUICK = settings(derandomize=True, deadline=None, max_examples=50)
TOKEN = "the-token"
ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)


def text_of(**given):
    return json.dumps({"token": TOKEN, "number": 1, **given})


def test_what_may_be_asked_for():
    for given_, expected in (
        ({"do": "goal", "x": 1, "y": -2.5}, PageCommand(1, "goal", at=(1.0, -2.5))),
        ({"do": "estop"}, PageCommand(1, "estop")),
        ({"do": "resume", "number": 0, "extra": [1]}, PageCommand(0, "resume")),
        ({"do": "strategy", "name": "bounce"}, PageCommand(1, "strategy", strategy="bounce")),
    ):
        assert command_from_text(text_of(**given_), TOKEN) == expected


def test_what_may_not():
    for given_, key in (
        ({"do": "goal", "x": math.nan, "y": 0}, "x: got nan"),
        ({"do": "goal", "x": True, "y": 0}, "x: got True"),
        ({"do": "goal", "x": 10**300, "y": 0}, "x: got 1000"),
        ({"do": "goal", "x": 1}, "y: got None"),
        ({"do": "shutdown"}, "do: got 'shutdown'"),
        ({"do": "estop", "number": -1}, "number: got -1"),
        ({"do": "strategy", "name": "b" * 500}, "name: got"),
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
    ANYTHING | st.dictionaries(st.sampled_from(["number", "do", "x", "y", "name"]), ANYTHING),
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
