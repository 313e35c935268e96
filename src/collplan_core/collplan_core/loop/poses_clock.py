"""The time on the poses' clock, which stamps are read on."""


class PosesClock:
    """Estimate of the time on the poses' clock: stamp of the newest pose + local time since it was received.

    The clock of a motion-capture computer may be seconds off; it is never compared with the local one.
    """

    def __init__(self) -> None:
        self._stamp: float | None = None
        self._local = 0.0

    def received(self, stamp: float, local: float) -> None:
        """Registers a pose with this stamp [s, poses' clock], received at `local` [s, local clock]."""
        self._stamp, self._local = stamp, local

    def now(self, local: float) -> float | None:
        """The time on the poses' clock [s]; None before the first pose."""
        return None if self._stamp is None else self._stamp + (local - self._local)

    def age(self, local: float) -> float:
        """Local time since the newest pose was received [s]; infinite before the first."""
        return float("inf") if self._stamp is None else local - self._local
