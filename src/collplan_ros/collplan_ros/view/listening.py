"""The page's port: on this machine alone, and never another one than was asked for."""

import errno
import socket

ADDRESS = "127.0.0.1"
"""The only address that is listened on."""


class PortTaken(OSError):
    """The port cannot be listened on."""


def listening_socket(port: int) -> socket.socket:
    """A socket that listens on a port of this machine; 0 is any that is free.

    Raises:
        PortTaken: it cannot.
    """
    try:
        return socket.create_server((ADDRESS, port))
    except OSError as error:
        taken = error.errno == errno.EADDRINUSE
        why = "is taken by another program" if taken else f"cannot be listened on: {error.strerror or error}"
        raise PortTaken(f"view.port: {ADDRESS}:{port} {why}, expected a free port, as view.port {port + 1}") from None
