"""How often commands must and can be sent: refused at the start, not found out while driving."""

from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.parameters import Settings
from collplan_core.parameters.spec import ParameterError
from omnipuck_driver.codec import Encoder
from omnipuck_driver.command_rate import check_command_rate
from omnipuck_driver.messages import CommandMessage

DRIVER, LIMITS = Settings().driver, Settings().limits


def refusal(rate: float, baud: int = 115200, age: float = 0.2, n_wheels: int = 3) -> str:
    try:
        check_command_rate(replace(DRIVER, rate=rate, baud=baud), replace(LIMITS, command_age=age), n_wheels)
    except ParameterError as error:
        return str(error)
    return ""


def test_what_is_shipped_can_be_sent():
    assert refusal(DRIVER.rate, DRIVER.baud, LIMITS.command_age) == ""


def test_a_rate_too_low_for_the_age_of_commands_is_refused():
    assert refusal(5.0) == "driver.rate: got 5, expected at least 2 / limits.command_age = 10 Hz"
    assert refusal(10.0) == ""


def test_a_rate_too_high_for_the_line_is_refused():
    carried = "driver.baud 9600 carries no more frames of 39 bytes"
    assert refusal(50.0, baud=9600) == f"driver.rate: got 50, expected at most 24 Hz: {carried}"
    assert refusal(24.0, baud=9600) == ""


@settings(derandomize=True, deadline=None, max_examples=100)
@given(st.floats(5.0, 200.0), st.sampled_from([9600, 19200, 57600, 115200]), st.integers(3, 8), st.floats(-80.0, 80.0))
def test_what_is_not_refused_fits_the_line_whatever_is_commanded(rate, baud, n_wheels, speed):
    frame = Encoder().encode(CommandMessage(42, 1000, 20, 180, 0, 3, 7, (speed,) * n_wheels))
    assert (refusal(rate, baud, age=0.5, n_wheels=n_wheels) == "") == (10 * len(frame) * rate <= baud)
