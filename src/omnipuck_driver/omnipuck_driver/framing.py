"""Frames on the wire: delimiter, COBS(version, type, sequence, payload, CRC-32), delimiter. See docs/protocol.md.

This much is the same in every version of the protocol, so that two ends with different versions can still report it.
"""

import struct
from dataclasses import dataclass
from zlib import crc32

from cobs import cobs

VERSION = 2
DELIMITER = b"\0"
LARGEST_BODY = 128
"""Most bytes of a frame before COBS, CRC included."""
LARGEST_ENCODED = LARGEST_BODY + 1
SEQUENCES = 1 << 16

_HEAD = struct.Struct("<BBH")
_CRC = struct.Struct("<I")


class FrameError(ValueError):
    """A frame that cannot be used; `reason` names the kind, for counting."""

    def __init__(self, reason: str, message: str) -> None:
        super().__init__(message)
        self.reason = reason


@dataclass(frozen=True)
class Frame:
    """The content of a frame whose checksum is right."""

    version: int  # of the sender's protocol
    kind: int  # type of the message, on which the payload depends
    sequence: int  # goes up by one from frame to frame, 0 after 65535
    payload: bytes


def pack_frame(frame: Frame) -> bytes:
    r"""A frame as it goes out. The delimiter before it ends whatever noise came first.

    >>> pack_frame(Frame(2, 0x01, 7, b"\x2a\0\0\0")).hex(" ")
    '00 04 01 01 07 02 2a 01 01 05 a1 ab 75 dd 00'
    """
    body = _HEAD.pack(frame.version, frame.kind, frame.sequence) + frame.payload
    return DELIMITER + cobs.encode(body + _CRC.pack(crc32(body))) + DELIMITER


def unpack_frame(encoded: bytes) -> Frame:
    """The frame between two delimiters; FrameError: no COBS, too short, or a checksum that does not fit."""
    try:
        body = cobs.decode(encoded)
    except cobs.DecodeError as error:
        raise FrameError("cobs", f"no COBS: {error}") from None
    if len(body) < _HEAD.size + _CRC.size:
        raise FrameError("short", f"{len(body)} bytes, expected at least {_HEAD.size + _CRC.size}")
    content, (checksum,) = body[: -_CRC.size], _CRC.unpack(body[-_CRC.size :])
    if crc32(content) != checksum:
        raise FrameError("crc", f"checksum {checksum:08x}, expected {crc32(content):08x}")
    version, kind, sequence = _HEAD.unpack_from(content)
    return Frame(version, kind, sequence, content[_HEAD.size :])
