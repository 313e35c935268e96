"""A pseudo-terminal as the device's end of a serial cable, found under a path of one's own."""

import os
import termios
import tty
from contextlib import suppress
from pathlib import Path

MOST_READ = 65536


class PseudoTerminal:
    """Open from the start; reading and writing never wait. OSError: no link is at the path, or it cannot be written."""

    def __init__(self, link: Path) -> None:
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self._link = link
        try:
            self._point_link()
        except OSError:
            self.close()
            raise

    def read(self) -> bytes:
        """Returns the bytes received."""
        try:
            return os.read(self._master, MOST_READ)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> None:
        """Sends; bytes that no program reads are lost, as on a cable."""
        with suppress(BlockingIOError):
            os.write(self._master, data)

    def rate_is(self, baud: int) -> bool:
        """Returns whether the other end has set this rate [bit/s]."""
        rates = termios.tcgetattr(self._slave)[4:6]
        return all(rate == getattr(termios, f"B{baud}", baud) for rate in rates)

    def close(self) -> None:
        """Pulls the cable."""
        if self._leads_here():
            self._link.unlink()
        os.close(self._master)
        os.close(self._slave)

    def _leads_here(self) -> bool:
        return self._link.is_symlink() and os.readlink(self._link) == os.ttyname(self._slave)

    def _point_link(self) -> None:
        if self._link.exists() and not self._link.is_symlink():
            raise FileExistsError(f"{self._link}: exists and is no link, expected a path for emulator.link")
        # made aside and moved over an old one: whoever opens the path finds one or the other
        fresh = self._link.with_name(f".{self._link.name}_{os.getpid()}")
        fresh.unlink(missing_ok=True)
        fresh.symlink_to(os.ttyname(self._slave))
        os.replace(fresh, self._link)
