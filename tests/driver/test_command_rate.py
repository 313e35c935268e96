"""How often commands must and can be sent: refused at the start, not found out while driving."""

from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.parameters import Settings
from collplan_core.parameters.spec import ParameterError
from omnipuck_driver.codec import Encoder
from omnipuck_driver.kinematics import check_command_rate
from omnipuck_driver.messages import CommandMessage

DRIVER, LIMITS = Settings().driver, Settings().limits


def refusal(rate: float, baud: int = 115200, age: float = 0.2, n_wheels: int = 3) -> str:
    try:
        check_command_rate(replace(DRIVER, rate=rate, baud=baud), replace(LIMITS, command_age=age), n_wheels)
    except ParameterError as error:
        return str(error)
    return ""


def test_what_is_shipped_can_be_sent_and_what_cannot_is_refused():
    for asked, words in (
        ((DRIVER.rate, DRIVER.baud, LIMITS.command_age), ""),
        ((5.0,), "got 5, expected at least 2 / limits.command_age = 10 Hz"),
        ((50.0, 9600), "got 50, expected at most 24 Hz"),
        ((24.0, 9600), ""),
    ):
        assert words in refusal(*asked)
        assert bool(words) == bool(refusal(*asked))


@settings(max_examples=100)
@given(st.floats(5.0, 200.0), st.sampled_from([9600, 19200, 57600, 115200]), st.integers(3, 8), st.floats(-80.0, 80.0))
def test_what_is_not_refused_fits_the_line_whatever_is_commanded(rate, baud, n_wheels, speed):
    frame = Encoder().encode(CommandMessage(42, 1000, 20, 180, 0, 3, 7, (speed,) * n_wheels))
    assert (refusal(rate, baud, age=0.5, n_wheels=n_wheels) == "") == (10 * len(frame) * rate <= baud)
