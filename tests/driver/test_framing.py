"""Frames and the decoder: what was sent comes out, what was damaged does not, and memory stays bounded."""

import random
import struct

from damaged_frames import damaged
from hypothesis import given, settings
from hypothesis import strategies as st

from omnipuck_driver.codec import REASONS, Decoder, Encoder
from omnipuck_driver.framing import DELIMITER, LARGEST_ENCODED, VERSION, Frame, pack_frame
from omnipuck_driver.messages import NO_TEMPERATURE, Announce, CommandMessage, Hello, Telemetry, WheelCaps

U8, U16, U32 = (st.integers(0, 2**bits - 1) for bits in (8, 16, 32))
FLOATS = st.floats(width=32, allow_nan=False, allow_infinity=False)
WHEELS = st.lists(FLOATS, max_size=8).map(tuple)
NAMES = st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=12)
WHEEL_CAPS = st.builds(WheelCaps, *[st.floats(0.0, width=32, exclude_min=True, allow_infinity=False)] * 2)
HELLOS = st.builds(Hello, U32, WHEEL_CAPS)
COMMANDS = st.builds(CommandMessage, U32, U32, U16, U16, U8, U8, U8, WHEELS)
ANNOUNCEMENTS = st.builds(Announce, U32, U32, U8, U8, U16, WHEEL_CAPS, NAMES)
TEMPERATURES = st.integers(-(2**15), 2**15 - 1)
COUNTED = U16, U16, TEMPERATURES, U32, *6 * [U16]
TELEMETRY = st.builds(Telemetry, U32, U32, U32, *COUNTED, st.tuples(FLOATS, FLOATS), U8, U8, WHEELS)
MESSAGES = st.one_of(HELLOS, COMMANDS, ANNOUNCEMENTS, TELEMETRY)
CAPS = WheelCaps(70.5, 500.0)
QUICK = settings(derandomize=True, deadline=None, max_examples=150)


@given(st.lists(MESSAGES, max_size=6), st.data())
@QUICK
def test_what_was_sent_comes_out_however_it_is_cut(messages, data):
    encoder, decoder = Encoder(), Decoder()
    stream = b"".join(map(encoder.encode, messages))
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=5)))
    pieces = [stream[a:b] for a, b in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
    assert [m for piece in pieces for m in decoder.feed(piece)] == messages
    assert (decoder.accepted, decoder.lost, sum(decoder.dropped.values())) == (len(messages), 0, 0)
    assert decoder.taken == len(stream)


@given(st.lists(st.binary(max_size=400), max_size=10))
@QUICK
def test_noise_is_no_message_raises_nothing_and_fills_no_memory(pieces):
    decoder = Decoder()
    for piece in pieces:
        assert decoder.feed(piece) == []
        assert decoder.waiting <= LARGEST_ENCODED
    assert decoder.dropped.keys() <= set(REASONS)


@given(st.binary(max_size=300).map(lambda noise: noise.replace(DELIMITER, b"\x01")), MESSAGES)
@QUICK
def test_a_frame_after_noise_is_not_lost_with_it(noise, message):
    assert Decoder().feed(noise + Encoder().encode(message)) == [message]


def dropped_by(*stream: bytes) -> dict[str, int]:
    decoder = Decoder()
    for data in stream:
        decoder.feed(data)
    return dict(decoder.dropped)


def test_what_is_dropped_is_counted_by_its_reason():
    hello = Hello(42, CAPS).pack()
    good = pack_frame(Frame(VERSION, 0x01, 0, hello))
    assert dropped_by(good, b"\x05\x01\x00") == {"cobs": 1}
    assert dropped_by(b"\x02\x41\x00") == {"short": 1}
    assert dropped_by(good[:5] + bytes([good[5] ^ 1]) + good[6:]) == {"crc": 1}
    assert dropped_by(b"\x01" * (LARGEST_ENCODED + 1), b"\x00") == {"oversized": 1}
    (other := Decoder()).feed(pack_frame(Frame(9, 0x77, 0, b"whatever it means there")))
    assert (other.dropped, other.other_version) == ({"version": 1}, 9)
    assert dropped_by(pack_frame(Frame(VERSION, 0x33, 0, hello))) == {"type": 1}
    assert dropped_by(pack_frame(Frame(VERSION, 0x01, 0, hello + b"\x00"))) == {"content": 1}
    nan = CommandMessage(1, 0, 0, 0, 0, 0, 0, (float("nan"),)).pack()
    assert dropped_by(pack_frame(Frame(VERSION, 0x02, 0, nan))) == {"content": 1}
    assert dropped_by(pack_frame(Frame(VERSION, 0x01, 0, struct.pack("<Iff", 42, 0.0, 500.0)))) == {"content": 1}


def test_repetitions_are_dropped_and_gaps_counted():
    decoder = Decoder()

    def arrives(sequence: int) -> bool:
        return bool(
            decoder.feed(pack_frame(Frame(VERSION, 0x02, sequence, CommandMessage(1, 0, 0, 0, 0, 0, 0, ()).pack())))
        )

    assert [arrives(n) for n in (65534, 65534, 65535, 0, 65535, 3, 2)] == [True, False, True, True, False, True, False]
    assert (decoder.lost, decoder.dropped["repeated"]) == (2, 3)
    # a hello begins the numbering anew
    assert decoder.feed(pack_frame(Frame(VERSION, 0x01, 1, Hello(1, CAPS).pack())))
    assert arrives(2)


def accepted_damage(frames: int) -> int:
    """Messages that came out of damaged frames and are not what was sent."""
    random_, wrong = random.Random(5), 0
    decoder, encoder = Decoder(), Encoder()
    for n in range(frames):
        wheels = tuple(random_.randrange(-1280, 1280) / 16 for _ in range(3))  # whole in four bytes
        command = CommandMessage(7, n, 20, 180, 0, 0, n % 256, wheels)
        telemetry = Telemetry(
            7, 8, n, 1, 7400, NO_TEMPERATURE, n, 3, 20, n % 9, 0, 0, 0, (0.0, 0.0), 0, n % 256, wheels
        )
        message = command if n % 2 else telemetry
        sent = encoder.encode(message)
        came = decoder.feed(damaged(sent, random_) + DELIMITER)
        wrong += sum(m != message for m in came)
        assert decoder.waiting <= LARGEST_ENCODED
    assert sum(decoder.dropped.values()) > 0.6 * frames
    return wrong


def test_no_damaged_frame_is_accepted():
    # chance of one by the CRC: at most 2^-32 each, 2.3e-6 in all
    assert accepted_damage(10_000) == 0
