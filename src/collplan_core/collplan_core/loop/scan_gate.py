"""Gate that stops the robot while scans are rejected."""

REJECTED_IN_A_ROW = 2
"""Number of scans rejected in a row that stops the robot; a single one is left out."""
PAUSE = 0.5
"""Time for which the robot stands after the last refusal, the first time [s]."""
RECENT = 10.0
"""Time after a stop within which another stop lasts twice as long [s]: a robot at rest sees nothing of a delay, and
would drive on into the next one."""


class ScanGate:
    """Counts rejected and accepted scans, each at `local` [s, local clock], and decides whether to stand still."""

    def __init__(self) -> None:
        """Starts with an open gate."""
        self._rejected_in_a_row = 0
        self._reason = ""
        self._stopped_at = float("-inf")
        self._pause = 0.0

    def reject(self, reason: str, local: float) -> None:
        """Counts a rejected scan."""
        self._rejected_in_a_row += 1
        self._reason = reason
        if self._rejected_in_a_row == REJECTED_IN_A_ROW:
            again = local - self._stopped_at <= self._pause + RECENT
            self._pause = 2.0 * self._pause if again else PAUSE
        if self._rejected_in_a_row >= REJECTED_IN_A_ROW:
            self._stopped_at = local

    def accept(self) -> None:
        """Counts an accepted scan."""
        self._rejected_in_a_row = 0

    @property
    def is_closed(self) -> bool:
        """True where the newest scans were rejected."""
        return self._rejected_in_a_row >= REJECTED_IN_A_ROW

    def why_not(self, local: float) -> str:
        """Returns the reason why scans must not be used for driving now; "" where they may."""
        standing = self.is_closed or local - self._stopped_at < self._pause
        return f"scan refused: {self._reason}" if standing else ""
