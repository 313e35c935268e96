"""Trust in scans of which some were refused."""

REFUSED_RUNNING = 2
"""Number of scans refused in a row that stops the robot; a single one is left out."""
PAUSE = 0.5
"""Time for which the robot stands after the last refusal, the first time [s]."""
RECENT = 10.0
"""Where it has to stand again within this time, it stands twice as long [s]: a robot at rest sees nothing of a delay,
and would drive on into the next one."""


class ScanTrust:
    """Counts refused and accepted scans, each at `local` [s, local clock], and decides whether to stand still."""

    def __init__(self) -> None:
        """Starts with trust."""
        self._running = 0
        self._reason = ""
        self._stood = float("-inf")
        self._pause = 0.0

    def refused(self, reason: str, local: float) -> None:
        """Counts a refused scan."""
        self._running += 1
        self._reason = reason
        if self._running == REFUSED_RUNNING:
            again = local - self._stood <= self._pause + RECENT
            self._pause = 2.0 * self._pause if again else PAUSE
        if self._running >= REFUSED_RUNNING:
            self._stood = local

    def believed(self) -> None:
        """Counts an accepted scan."""
        self._running = 0

    @property
    def is_lost(self) -> bool:
        """True where the newest scans were refused."""
        return self._running >= REFUSED_RUNNING

    def why_not(self, local: float) -> str:
        """Returns the reason why scans must not be used for driving now; "" where they may."""
        standing = self.is_lost or local - self._stood < self._pause
        return f"scan refused: {self._reason}" if standing else ""
