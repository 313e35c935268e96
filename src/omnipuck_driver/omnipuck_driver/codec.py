"""Messages to bytes, and a stream of bytes to messages, whatever faults the line has. Opens no port."""

from collections import Counter

from omnipuck_driver.framing import (
    DELIMITER,
    LARGEST_ENCODED,
    SEQUENCES,
    VERSION,
    Frame,
    FrameError,
    pack_frame,
    unpack_frame,
)
from omnipuck_driver.messages import FROM_DEVICE, TO_DEVICE, Announce, Hello, Kinds, Message, unpack_message

REASONS = ("oversized", "cobs", "short", "crc", "version", "type", "content", "repeated")
"""Reasons for which something between two delimiters is dropped."""


class Encoder:
    """Numbers the frames it makes."""

    def __init__(self, version: int = VERSION) -> None:
        self._version = version
        self._sequence = 0

    def encode(self, message: Message) -> bytes:
        """The bytes of the next frame."""
        frame = Frame(self._version, message.KIND, self._sequence, message.pack())
        self._sequence = (self._sequence + 1) % SEQUENCES
        return pack_frame(frame)


class Decoder:
    """Decodes the messages in a stream of bytes; keeps at most one frame, and drops and counts invalid data.

    A frame whose number is that of the frame before, or an earlier one, is a repetition and dropped. Hello and Announce
    begin the numbering anew. A message that is not among `kinds` is of unknown type.
    """

    def __init__(self, version: int = VERSION, kinds: Kinds = TO_DEVICE + FROM_DEVICE) -> None:
        self.dropped: Counter[str] = Counter()  # counts of frames by reason
        self.accepted = 0  # messages returned
        self.lost = 0  # sequence numbers that never arrived
        self.taken = 0  # bytes fed
        self.other_version: int | None = None  # newest version seen that is not this one
        self._version = version
        self._kinds = kinds
        self._buffer = bytearray()
        self._overflown = False
        self._last: int | None = None

    def feed(self, data: bytes) -> list[Message]:
        """Returns the messages that end in these bytes, in order."""
        self.taken += len(data)
        first, *others = data.split(DELIMITER)
        self._keep(first)
        messages = []
        for piece in others:
            message = self._finished()
            if message is not None:
                messages.append(message)
            self._keep(piece)
        return messages

    @property
    def waiting(self) -> int:
        """Bytes kept of a frame that has begun."""
        return len(self._buffer)

    def forget(self) -> None:
        """Drops a frame that has begun, as after the line was cut."""
        self._buffer.clear()
        self._overflown = False
        self._last = None

    def _keep(self, piece: bytes) -> None:
        if self._overflown or len(self._buffer) + len(piece) > LARGEST_ENCODED:
            self._overflown = True
            self._buffer.clear()
        else:
            self._buffer += piece

    def _finished(self) -> Message | None:
        encoded, overflown = bytes(self._buffer), self._overflown
        self._buffer.clear()
        self._overflown = False
        if overflown:
            self.dropped["oversized"] += 1
            return None
        if not encoded:
            return None
        try:
            message = self._opened(encoded)
        except FrameError as error:
            self.dropped[error.reason] += 1
            return None
        self.accepted += 1
        return message

    def _opened(self, encoded: bytes) -> Message:
        frame = unpack_frame(encoded)
        if frame.version != self._version:
            self.other_version = frame.version
            raise FrameError("version", f"version {frame.version}, expected {self._version}")
        message = unpack_message(frame.kind, frame.payload, self._kinds)
        self._count(frame.sequence, begins=isinstance(message, (Hello, Announce)))
        return message

    def _count(self, sequence: int, begins: bool) -> None:
        if self._last is not None and not begins:
            step = (sequence - self._last) % SEQUENCES
            if step == 0 or step >= SEQUENCES // 2:
                raise FrameError("repeated", f"number {sequence} after {self._last}")
            self.lost += step - 1
        self._last = sequence
