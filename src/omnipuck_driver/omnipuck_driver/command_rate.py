"""Rate of commands: how often they must be sent, and how often the line can carry one."""

from collplan_core.parameters import Driver, Limits
from collplan_core.parameters.spec import ParameterError
from omnipuck_driver.codec import Encoder
from omnipuck_driver.messages import CommandMessage

BITS_PER_BYTE = 10
"""On the line: a start bit, 8 of data, a stop bit."""
FEWEST = 2
"""Commands sent within limits.command_age: one may be lost, and the wheels turn on."""


def check_command_rate(driver: Driver, limits: Limits, n_wheels: int) -> None:
    """Checks that commands of so many wheels come before the last one is too old, and that the line carries them all.

    Raises:
        ParameterError: driver.rate is too low for limits.command_age, or too high for driver.baud.
    """
    least = FEWEST / limits.command_age
    if driver.rate < least:
        raise ParameterError(
            f"driver.rate: got {driver.rate:g}, expected at least {FEWEST} / limits.command_age = {least:.4g} Hz"
        )
    length = len(Encoder().encode(CommandMessage(0, 0, 0, 0, 0, 0, 0, (0.0,) * n_wheels)))
    most = driver.baud / BITS_PER_BYTE / length
    if driver.rate > most:
        raise ParameterError(
            f"driver.rate: got {driver.rate:g}, expected at most {int(most)} Hz: "
            f"driver.baud {driver.baud} carries no more frames of {length} bytes"
        )
