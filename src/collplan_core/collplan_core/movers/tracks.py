"""Movers over the scans: each cluster of returns continues a track or begins one."""

from dataclasses import dataclass, replace

import numpy as np

KEPT_SIGHTS = 8
"""Newest sights of a track that are kept."""
VELOCITY_SPAN = 0.2
"""Sights of this span are fitted for the velocity: over a longer one a mover that turns back is seen too late [s]."""
GATE, GATE_SPEED = 0.2, 1.0
"""Largest distance of a cluster from the place predicted for its track [m], and by the time since its last sight
[m/s]."""
FASTEST = 2.5
"""A faster fit is one of wrong clusters [m/s]."""
CERTAIN = 5
"""From so many sights on a velocity counts in full: what comes out from behind an edge first seems to move anyhow."""
GROWTH_OF_FEW = 1.2
"""Growth added to a track, by its number of sights: its velocity is not known yet [m/s]."""
LEAST_RADIUS, MOST_RADIUS = 0.10, 0.30
"""Bounds of a mover's radius, of which a scan shows a part [m]."""
CONFIRMED = 2
"""Sights from which on a track counts: a single cluster may be of chance."""


@dataclass(frozen=True, eq=False)
class Track:
    """The newest sights of one mover.

    Attributes:
        number: its number.
        sights: number of scans that showed it.
        times: (m,) stamps of the newest of these [s].
        centers: (m, 2) [m]; radii: (m,) [m].
    """

    number: int
    sights: int
    times: np.ndarray
    centers: np.ndarray
    radii: np.ndarray

    def seen_again(self, time: float, center: np.ndarray, radius: float) -> "Track":
        """The track with one more sight."""
        return replace(
            self,
            sights=self.sights + 1,
            times=np.append(self.times, time)[-KEPT_SIGHTS:],
            centers=np.vstack([self.centers, center])[-KEPT_SIGHTS:],
            radii=np.append(self.radii, radius)[-KEPT_SIGHTS:],
        )

    @property
    def last_seen(self) -> float:
        """Stamp of the newest sight [s]."""
        return float(self.times[-1])

    @property
    def radius(self) -> float:
        """The largest of the newest radii: a mover is often half hidden [m]."""
        return float(self.radii[-4:].max())

    def motion_at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Place (2,) [m] and velocity (2,) [m/s] at a time [s], by a straight fit to the newest sights."""
        recent = self.times > self.times[-1] - VELOCITY_SPAN - 1e-6
        t, c = self.times[recent], self.centers[recent]
        if len(t) < 2:
            return self.centers[-1].copy(), np.zeros(2)
        middle, from_middle = c.mean(axis=0), t - t.mean()
        velocity = (from_middle @ (c - middle)) / (from_middle @ from_middle)
        velocity *= min(1.0, FASTEST / max(float(np.hypot(*velocity)), 1e-9))
        velocity *= min(1.0, (self.sights - 1) / (CERTAIN - 1))
        newest = 0.5 * (c[-1] + middle + velocity * from_middle[-1])
        return newest + velocity * (time - t[-1]), velocity


def with_clusters(
    tracks: tuple[Track, ...], number: int, time: float, clusters: list[tuple[np.ndarray, float]]
) -> tuple[tuple[Track, ...], int]:
    """The tracks after the clusters of a scan: nearest first, each continues one track or begins its own.

    Args:
        number: number of the next new track.
        time: stamp of the scan [s].
        clusters: center (2,) and radius of each [m].

    Returns:
        the tracks, and the next number.
    """
    places = [track.motion_at(time)[0] for track in tracks]
    pairs = sorted(
        (float(np.hypot(*(places[i] - center))), i, k)
        for i in range(len(tracks))
        for k, (center, _) in enumerate(clusters)
    )
    after, taken = list(tracks), set()
    continued: set[int] = set()
    for distance, i, k in pairs:
        gate = GATE + GATE_SPEED * (time - tracks[i].last_seen)
        if distance < gate and i not in continued and k not in taken:
            after[i] = tracks[i].seen_again(time, *clusters[k])
            continued.add(i)
            taken.add(k)
    for k, (center, radius) in enumerate(clusters):
        if k not in taken:
            after.append(Track(number, 1, np.array([time]), center[None].copy(), np.array([radius])))
            number += 1
    return tuple(after), number
