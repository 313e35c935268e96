"""After an emergency stop: nothing but a zero command, or silence, arms a robot again."""

from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.control.arming import ARMED, Arming

SILENCE = 0.2


def test_armed_it_follows_everything():
    assert not ARMED.is_waiting(0.0, SILENCE)
    assert ARMED.after_command(False, 5.0, SILENCE) == ARMED


def test_one_zero_command_arms():
    waiting = Arming(10.0).after_command(False, 10.05, SILENCE)
    assert waiting.is_waiting(10.05, SILENCE)
    assert waiting.after_command(True, 10.1, SILENCE) == ARMED


def test_silence_arms():
    assert Arming(10.0).is_waiting(10.0 + 0.99 * SILENCE, SILENCE)
    assert not Arming(10.0).is_waiting(10.0 + 1.01 * SILENCE, SILENCE)
    assert Arming(10.0).after_command(False, 10.0 + 1.01 * SILENCE, SILENCE) == ARMED


@given(st.lists(st.floats(0.0, 0.99 * SILENCE), max_size=50))
@settings(derandomize=True, deadline=None, max_examples=50)
def test_commands_that_never_pause_are_never_followed(pauses):
    now, arming = 10.0, Arming(10.0)
    for pause in pauses:
        now += pause
        arming = arming.after_command(False, now, SILENCE)
        assert arming.is_waiting(now, SILENCE)
