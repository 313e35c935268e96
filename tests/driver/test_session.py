"""The driver's end of the protocol without a port: what it says of a firmware that does not do what it should."""

from dataclasses import replace

import pytest
from telemetry_example import TELEMETRY

from omnipuck_driver.codec import Encoder
from omnipuck_driver.messages import NEVER, Announce, WheelCaps
from omnipuck_driver.session import TOO_LATE, HeldCommand, Permission, Session, WheelCommand

CAPS = WheelCaps(70.5, 500.0)
ANNOUNCE = Announce(TELEMETRY.session, TELEMETRY.boot, 0, 3, 500, CAPS, "puck 2.0")


class Talk:
    """A session, and a firmware that says what the test wants."""

    def __init__(self) -> None:
        self.session = Session(3, 0.3, CAPS, new_token=lambda: TELEMETRY.session)
        self.encoder = Encoder()

    def hears(self, *messages, now: float = 0.0) -> "Talk":
        self.session.receive(b"".join(map(self.encoder.encode, messages)), now)
        return self

    def sends(self, now: float) -> bytes:
        return self.session.outgoing(WheelCommand((0.0,) * 3, 0.0, 0.2), Permission(False, True, 0, 0), now)

    @property
    def trouble(self) -> str:
        return self.session.trouble()


def test_a_firmware_that_takes_commands_is_no_trouble_and_one_that_never_did_is_waited_for():
    assert Talk().hears(ANNOUNCE, TELEMETRY).trouble == ""
    for delay in (0, NEVER):
        silent = replace(TELEMETRY, echo=0, echo_delay=delay)
        assert Talk().hears(ANNOUNCE, silent).trouble == "waiting until the firmware takes commands"


def test_a_firmware_that_takes_none_any_more_is_named():
    talk = Talk().hears(ANNOUNCE, replace(TELEMETRY, echo_delay=1000))
    assert talk.trouble == ""
    assert talk.hears(replace(TELEMETRY, echo_delay=1001)).trouble == TOO_LATE
    assert talk.session.connected
    assert talk.hears(TELEMETRY).trouble == ""


def test_a_firmware_that_is_heard_and_does_not_answer_is_not_taken_for_another_rate():
    talk = Talk()
    assert talk.trouble.startswith("no answer")
    talk.session.receive(b"\x11\x22\x00\x33", 0.0)
    assert talk.trouble.startswith("bytes arrive but make no whole frames")
    # as it speaks without a session: the line to it is cut, or garbled
    talk.hears(replace(TELEMETRY, session=0, echo=0))
    assert talk.trouble == "bytes of the firmware are received, but no answer: is the line to it connected?"
    assert talk.hears(ANNOUNCE, TELEMETRY).trouble == ""


def test_what_was_heard_in_a_session_before_says_nothing_of_the_next():
    talk = Talk().hears(ANNOUNCE, TELEMETRY)
    assert talk.sends(now=0.1)
    talk.sends(now=1.0)
    assert talk.session.ended_by == "the firmware fell silent"
    assert talk.trouble.startswith("no answer")


def test_telemetry_tells_of_a_permission_once_the_firmware_has_heard_of_it():
    permission = Permission(stopped=False, held=False, cleared=258, released=3)
    for changes, is_told in (({}, True), ({"echo": 0}, False), ({"cleared": 3}, False), ({"released": 2}, False)):
        telemetry = replace(TELEMETRY, **{"cleared": 2, "released": 3, **changes})
        assert permission.is_told_by(telemetry) == is_told, changes


def test_a_held_command_lives_as_long_as_its_age_leaves_it():
    held = HeldCommand((1.0, 2.0, 3.0), given=10.0)
    sent = held.wheel_command(10.05, longest_age=0.2)
    assert (sent.wheels, sent.age, sent.life) == (held.wheels, pytest.approx(0.05), pytest.approx(0.15))
    assert held.wheel_command(10.25, longest_age=0.2) is None
