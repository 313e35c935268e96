"""What scans and plans hold, which a journal refers to by stamp and hash: they are large, and recorded elsewhere."""

import struct
from hashlib import blake2b
from typing import Any

import numpy as np

from collplan_core.plan import Plan, timed_path
from collplan_core.replay.values import PLAN, SCAN, JournalError, Reference, decode, encode, little_endian
from collplan_core.scan import Scan

HASH_SIZE = 8
"""[bytes]"""


class Missing(LookupError):
    """What a journal refers to is not there."""

    def __init__(self, reference: Reference) -> None:
        """Names it."""
        super().__init__(f"the {reference} that was taken is not in the recording")


class Altered(LookupError):
    """There is another scan or plan with the stamp of the one that a journal refers to.

    Attributes:
        taken, found: what stands for the one and the other.
    """

    def __init__(self, taken: Reference, found: Reference) -> None:
        """Names them."""
        super().__init__(f"the {taken} is not the one that was taken")
        self.taken, self.found = taken, found


def reference_to(value: Scan | Plan) -> Reference:
    """What stands for a scan or a plan."""
    numbers, arrays = _parts(value)
    return Reference(SCAN if isinstance(value, Scan) else PLAN, value.stamp, hash_of(numbers, arrays))


def hash_of(numbers: list[float], arrays: list[np.ndarray]) -> str:
    """BLAKE2b over numbers and arrays as little-endian float64, in hexadecimal digits."""
    digest = blake2b(struct.pack(f"<{len(numbers)}d", *numbers), digest_size=HASH_SIZE)
    for array in arrays:
        digest.update(little_endian(array))
    return digest.hexdigest()


def _parts(value: Scan | Plan) -> tuple[list[float], list[np.ndarray]]:
    """The numbers and arrays that a loop reads of it; of a plan no more than what a timed path says."""
    if isinstance(value, Plan):
        return [value.stamp], [value.times, value.positions, value.velocities]
    beams = [value.stamp, value.angle_min, value.angle_increment, value.range_min, value.range_max]
    return [*beams, value.time_increment], [value.ranges]


def content_of(value: Scan | Plan) -> dict[str, Any]:
    """What a scan or a plan holds, as JSON."""
    return {SCAN if isinstance(value, Scan) else PLAN: encode(list(_parts(value)))}


def value_of(content: dict[str, Any]) -> Scan | Plan:
    """The scan or plan of `content_of`.

    Raises:
        JournalError: it is neither.
        ScanError: what it holds is no scan.
    """
    try:
        ((kind, held),) = content.items()
        numbers, arrays = decode(held)
        if kind == SCAN:
            stamp, first, step, nearest, farthest, between = numbers
            return Scan(stamp, first, step, nearest, farthest, arrays[0], between)
        (stamp,), (times, positions, velocities) = numbers, arrays
    except (AttributeError, TypeError, ValueError) as error:
        raise JournalError(f"contents: got {content!s:.80}, expected a scan or a plan ({error})") from None
    return timed_path(stamp, times, positions, velocities)


class Contents:
    """Scans and plans, found by what refers to them."""

    def __init__(self) -> None:
        """Starts empty."""
        self._values: dict[Reference, Scan | Plan] = {}
        self._by_stamp: dict[tuple[str, float], Reference] = {}

    def add(self, value: Scan | Plan) -> None:
        """Takes a scan or a plan."""
        reference = reference_to(value)
        self._values[reference] = value
        self._by_stamp[reference.kind, reference.stamp] = reference

    def find(self, reference: Reference) -> Scan | Plan:
        """What a reference stands for.

        Raises:
            Missing: it is not there.
            Altered: another one with its stamp is.
        """
        if reference in self._values:
            return self._values[reference]
        other = self._by_stamp.get((reference.kind, reference.stamp))
        raise Missing(reference) if other is None else Altered(reference, other)

    def plan_at(self, stamp: float) -> Plan | None:
        """The plan with this stamp [s]; None where there is none."""
        reference = self._by_stamp.get((PLAN, stamp))
        found = None if reference is None else self._values[reference]
        return found if isinstance(found, Plan) else None
