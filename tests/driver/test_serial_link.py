"""The serial device without a node: what cannot be opened says why, and how often it is tried and written to."""

import errno
import os
import pty
import termios
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import pytest

from collplan_core.parameters import Settings
from omnipuck_driver import serial_link
from omnipuck_driver.messages import WheelCaps
from omnipuck_driver.session import Permission, WheelCommand

DRIVER, CAPS = Settings().driver, WheelCaps(70.5, 500.0)


def test_a_device_that_cannot_be_opened_says_what_to_do(tmp_path, monkeypatch):
    for number, said in (
        (errno.ENOENT, "plugged in"),
        (errno.EACCES, "join group"),
        (errno.EBUSY, "busy"),
        (errno.EIO, "broken"),
    ):
        assert said in serial_link.described("/dev/ttyUSB0", 115200, OSError(number, os.strerror(number)))
    (tmp_path / "file").write_text("")
    with pytest.raises(serial_link.PortError, match="not a serial device"):
        serial_link.open_port(str(tmp_path / "file"), 115200)
    # the cable is pulled while the device is opened
    for call in ("tcsetattr", "tcflush"):
        for number, said in ((errno.EIO, "broken"), (errno.ENODEV, "no such device")):

            def gone(*_, number=number):
                raise termios.error(number, os.strerror(number))

            master, slave = pty.openpty()
            with monkeypatch.context() as patched:
                patched.setattr(termios, call, gone)
                with pytest.raises(serial_link.PortError, match=said):
                    serial_link.open_port(os.ttyname(slave), 115200)
            os.close(master)
            os.close(slave)


def test_attempts_to_open_come_ever_more_seldom(monkeypatch):
    times, now = [], 0.0

    def refuse(path, baud):
        times.append(now)
        raise serial_link.PortError("no")

    monkeypatch.setattr(serial_link, "open_port", refuse)
    link = serial_link.SerialLink(DRIVER, 3, CAPS)
    while now < 5.0:
        link.receive(now)
        now += 0.02
    pauses = [b - a for a, b in pairwise(times)]
    assert pauses == sorted(pauses)
    assert pauses[0] < 0.1 < 0.9 < pauses[-1] < 1.1


def test_no_more_waits_in_the_device_than_leaves_it_in_20_ms(monkeypatch):
    port_ = SimpleNamespace(out_waiting=0, read=lambda most: b"", write=lambda frame: None)
    monkeypatch.setattr(serial_link, "open_port", lambda path, baud: port_)
    monkeypatch.setattr(serial_link, "select", lambda *_: ([], [port_], []))
    for baud, most in ((9600, 19), (115200, 230)):
        link = serial_link.SerialLink(replace(DRIVER, baud=baud), 3, CAPS)
        link.receive(0.0)
        for n, port_.out_waiting in enumerate([most, most + 1]):
            link.send(WheelCommand((0.0,) * 3, 0.0, 0.2), Permission(False, True, 0, 0), float(n))
            assert (link.sent, link.unsent) == (1, n)
