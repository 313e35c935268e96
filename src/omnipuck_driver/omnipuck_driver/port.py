"""Opening a serial device, with an error message that names the remedy where it cannot be opened."""

import errno
import termios
from pathlib import Path

import serial


class PortError(OSError):
    """Error of a device that cannot be opened."""


def open_port(path: str, baud: int) -> serial.Serial:
    """Opens the device for this process alone; reading and writing never block.

    Raises:
        PortError: missing, not permitted, in use, no serial device, or a rate it cannot do.
    """
    try:
        return serial.Serial(path, baud, timeout=0, write_timeout=0, exclusive=True)
    except (OSError, ValueError, termios.error) as error:
        raise PortError(described(path, baud, error)) from None


def described(path: str, baud: int, error: Exception) -> str:
    """Returns the error message: the fault of a device, and its remedy."""
    # pyserial lets through that of a device that goes while it is set up, which has no errno
    number = error.args[0] if isinstance(error, termios.error) else getattr(error, "errno", None)
    if number in (errno.ENOENT, errno.ENODEV, errno.ENXIO):
        return f"{path}: no such device: is the cable plugged in, the robot switched on? (driver.port)"
    if number in (errno.EACCES, errno.EPERM):
        return f"{path}: no permission: join group {_group(path)} (sudo usermod -aG {_group(path)} $USER, log in again)"
    if number in (errno.EBUSY, errno.EAGAIN):
        return f"{path}: busy: another program has it open; end that one"
    if isinstance(error, ValueError):
        return f"{path}: cannot do {baud} bit/s: choose another driver.baud, as the firmware's"
    return f"{path}: not a serial device, or a broken one ({error})"


def _group(path: str) -> str:
    try:
        return Path(path).group()
    except (OSError, KeyError):
        return "dialout"
