"""Faults of a serial line, on request."""

import numpy as np

from collplan_core.parameters import EmulatorFaults

LARGEST_NOISE = 12
"""Longest burst of noise before a frame [bytes]."""


class BadLine:
    """One direction of a serial line; equal seeds make equal faults."""

    def __init__(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)
        self._held = b""

    def passed(self, data: bytes, faults: EmulatorFaults) -> bytes:
        """The bytes that come out when `data` goes in; a frame is the bytes between two delimiters."""
        sent, self._held = self._held, b""
        pieces = data.split(b"\0")
        for i, piece in enumerate(pieces):
            ending = b"" if i == len(pieces) - 1 else b"\0"
            sent += (self._frame(piece, faults) if piece else b"") + ending
        if data and self._happens(faults.split):
            half = len(sent) // 2
            sent, self._held = sent[:half], sent[half:]
        return self._flipped(sent, faults.flipped)

    def _frame(self, frame: bytes, faults: EmulatorFaults) -> bytes:
        if self._happens(faults.lost):
            return b""
        if self._happens(faults.cut):
            frame = frame[: int(self._random.integers(len(frame)))]
        if self._happens(faults.doubled):
            frame = frame + b"\0" + frame
        if self._happens(faults.noise):
            frame = self._random.bytes(int(self._random.integers(1, LARGEST_NOISE))) + b"\0" + frame
        return frame

    def _flipped(self, data: bytes, share: float) -> bytes:
        if not share or not data:
            return data
        values = np.frombuffer(data, np.uint8).copy()
        struck = self._random.random(len(values)) < share
        values[struck] ^= (1 << self._random.integers(0, 8, int(struck.sum()))).astype(np.uint8)
        return values.tobytes()

    def _happens(self, share: float) -> bool:
        return share > 0.0 and bool(self._random.random() < share)
