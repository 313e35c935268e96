"""Statistics of the controller's period, for its diagnostics."""

from collections import deque

import numpy as np


class ControlPeriod:
    """Percentiles of the time between successive commands."""

    def __init__(self, kept: int = 1200) -> None:
        """Keeps the last `kept` periods; the default is a minute at 20 Hz."""
        self._periods: deque[float] = deque(maxlen=kept)
        self._last: float | None = None

    def tick(self, local: float) -> None:
        """Registers a command sent at `local` [s, local clock]."""
        if self._last is not None:
            self._periods.append(local - self._last)
        self._last = local

    @property
    def values(self) -> dict[str, object]:
        """Values of a `Health`: p50 and p99 [ms], and the number of periods n."""
        if not self._periods:
            return {"control_period_ms.n": 0}
        p50, p99 = np.percentile(self._periods, [50, 99])
        return {
            "control_period_ms.p50": 1e3 * float(p50),
            "control_period_ms.p99": 1e3 * float(p99),
            "control_period_ms.n": len(self._periods),
        }
