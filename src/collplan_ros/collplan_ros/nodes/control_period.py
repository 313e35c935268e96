"""How regular the controller's period is."""

from collections import deque

import numpy as np


class ControlPeriod:
    """The times between the last commands, as percentiles."""

    def __init__(self, kept: int = 1200) -> None:
        """Over so many periods, a minute at 20 Hz."""
        self._periods: deque[float] = deque(maxlen=kept)
        self._last: float | None = None

    def tick(self, local: float) -> None:
        """A command goes out at `local` [s]."""
        if self._last is not None:
            self._periods.append(local - self._last)
        self._last = local

    @property
    def values(self) -> dict[str, object]:
        """Ready for a `Health`: p50, p99 [ms] and n."""
        if not self._periods:
            return {"control_period_ms.n": 0}
        p50, p99 = np.percentile(self._periods, [50, 99])
        return {
            "control_period_ms.p50": 1e3 * float(p50),
            "control_period_ms.p99": 1e3 * float(p99),
            "control_period_ms.n": len(self._periods),
        }
