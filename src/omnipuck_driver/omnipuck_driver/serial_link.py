"""The serial device, opened again and again until it is there, and the session on it."""

import errno
import termios
from pathlib import Path
from select import select

import serial

from collplan_core.parameters import Driver
from omnipuck_driver.kinematics import BITS_PER_BYTE
from omnipuck_driver.messages import Telemetry, WheelCaps
from omnipuck_driver.session import Permission, Session, WheelCommand


class PortError(OSError):
    """Error of a device that cannot be opened."""


def open_port(path: str, baud: int) -> serial.Serial:
    """Opens the device for this process alone; reading and writing never block.

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


FIRST_WAIT = 0.05
"""Pause after the first attempt in vain; each further one takes twice as long, up to LONGEST_WAIT [s]."""
LONGEST_WAIT = 1.0
"""Longest pause between two attempts to open the device [s]."""
LINK_TIMEOUT = 0.3
"""Silence of the firmware after which a new session begins with a robot at rest [s]."""
MOST_READ = 4096
"""Most bytes read at once."""
LONGEST_QUEUE = 0.02
"""Time for which bytes may wait in the device; those behind more would be old when they arrive [s]."""


class SerialLink:
    """A serial device that never blocks; `receive` and `send` are to be called at the driver's rate."""

    def __init__(self, driver: Driver, n_wheels: int, caps: WheelCaps) -> None:
        """Opens nothing yet; no wheel is to exceed `caps`."""
        self.session = Session(n_wheels, LINK_TIMEOUT, caps)  # the conversation with the firmware
        self.waits_for = f"{driver.port}: not opened yet"  # why the device is not open; empty while it is
        self.sent = 0  # frames written
        self.unsent = 0  # frames dropped because the device was full
        self._driver = driver
        self._port: serial.Serial | None = None
        self._wait = FIRST_WAIT
        self._next_attempt = float("-inf")

    @property
    def armed(self) -> bool:
        """True where the firmware follows commands other than zero."""
        return self._port is not None and self.session.armed

    def trouble(self) -> str:
        """Returns the reason why nothing can move; "" while the firmware answers commands."""
        return self.waits_for or self.session.trouble()

    def receive(self, now: float) -> list[Telemetry]:
        """Returns the telemetry received until the local time `now` [s]; opens the device when an attempt is due."""
        if self._port is None:
            self._try_to_open(now)
        if self._port is None:
            return []
        try:
            data = self._port.read(MOST_READ)
        except OSError:
            self._lose(now)
            return []
        return self.session.receive(data, now)

    def send(self, wheel_command: WheelCommand, permission: Permission, now: float) -> None:
        """Sends the part of a wheel command that the session allows at the local time `now` [s]."""
        if self._port is None:
            return
        frame = self.session.outgoing(wheel_command, permission, now)
        try:
            if frame and self._has_room():
                self._port.write(frame)
                self.sent += 1
            elif frame:
                self.unsent += 1
        except OSError:
            self._lose(now)

    def drained(self) -> bool:
        """Returns whether all written bytes have left."""
        try:
            return self._port is None or self._port.out_waiting == 0
        except OSError:
            return True

    def close(self) -> None:
        """Gives the device back."""
        port, self._port = self._port, None
        if port is not None:
            port.close()

    def _has_room(self) -> bool:
        # write() of a full device would spin
        assert self._port is not None
        queue = self._port.out_waiting * BITS_PER_BYTE / self._driver.baud
        return queue < LONGEST_QUEUE and bool(select([], [self._port], [], 0)[1])

    def _try_to_open(self, now: float) -> None:
        if now < self._next_attempt:
            return
        try:
            self._port = open_port(self._driver.port, self._driver.baud)
        except PortError as error:
            self.waits_for = str(error)
            self._next_attempt = now + self._wait
            self._wait = min(2 * self._wait, LONGEST_WAIT)
            return
        self.waits_for = ""
        self._wait = FIRST_WAIT
        self.session.begin("the device was opened")

    def _lose(self, now: float) -> None:
        self.close()
        self.waits_for = f"{self._driver.port}: lost while open: is the cable plugged in?"
        self.session.begin(self.waits_for)
        self._next_attempt = now + self._wait
