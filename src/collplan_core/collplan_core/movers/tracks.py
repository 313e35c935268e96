"""Movers over the scans: each cluster of returns continues a track or begins one."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse.csgraph import connected_components

KEPT_SIGHTS = 8
"""Newest sights of a track that are kept."""
VELOCITY_SPAN = 0.2
"""Sights of this span are fitted for the velocity: over a longer one a mover that turns back is seen too late [s]."""
GATE, GATE_SPEED, GATE_OF_WALKER = 0.2, 1.0, 2.0
"""Largest distance of a cluster from the place predicted for its track [m], and by the time since its last sight
[m/s]: a leg that the other one hid comes out in swing."""
TRAIL_STEP, TRAIL_TIME = 0.15, 3.0
"""Distance between the places of a trail [m], and its length [s]: who walks there may come back."""
WALKED = 0.15
"""A track that has come so far from its first sight goes on where it stops [m]: walls beside a mover come nowhere."""
WALKED_IN = 0.5
"""One that has come so far is remembered where it stops [m]."""
STAYED = 20
"""So many sights show the same: who came to a stand where the robot first saw them is a mover nevertheless."""
FASTEST = 3.5
"""A faster fit is one of wrong clusters: a leg in swing has twice the speed of walking [m/s]."""
CERTAIN = 5
"""Number of sights from which on a velocity counts in full: beside an edge the first ones are wrong."""
GROWTH_OF_FEW = 1.2
"""Growth added to a track, by its number of sights: its velocity is not known yet [m/s]."""
LEAST_RADIUS, MOST_RADIUS = 0.10, 0.30
"""Bounds of a mover's radius, of which a scan shows a part [m]."""
STEP, BESIDE = 0.8, 0.45
"""Largest distance between the legs of a person at each sight that is kept, and at the nearest of these [m]."""
CONFIRMED = 2
"""Sights from which on a track counts: a single cluster may be of chance."""


class Cluster(NamedTuple):
    """Returns of one scan that belong together, as the disc that they show the front of."""

    center: np.ndarray  # (2,) [m]
    radius: float  # [m]
    moves: bool  # whether some of them lie where free space was seen; else they are only where a mover is expected


@dataclass(frozen=True, eq=False)
class Track:
    """The newest sights of one mover."""

    number: int  # its number
    sights: int  # number of scans that showed it
    first: np.ndarray  # (2,) its first centre [m]
    newest: np.ndarray  # (m, 4) stamp [s], centre and radius [m] of the newest of these
    trail: np.ndarray  # (h, 3) stamp [s] and centre [m] of sights about TRAIL_STEP apart in the last TRAIL_TIME
    came: float = 0.0  # the farthest that it was from its first centre [m]
    stopped: float = math.inf  # since when it is remembered where it stopped, unseen [s]; inf while it is seen

    def seen_again(self, time: float, cluster: Cluster) -> "Track":
        """The track with one more sight, in place of those that are not older: a scan may come again for one pose."""
        newest = np.vstack([self.newest[self.newest[:, 0] < time], [time, *cluster.center, cluster.radius]])
        trail = _with_place(self.trail, time, cluster.center)
        came = max(self.came, float(np.hypot(*(cluster.center - self.first))))
        kept = newest[-KEPT_SIGHTS:]
        return replace(self, sights=self.sights + 1, newest=kept, trail=trail, came=came, stopped=math.inf)

    def where_it_stopped(self, time: float) -> "Track":
        """The track of one that has been out of sight for long, and is taken to stand at its last place."""
        newest = np.array([[time, *self.centers[-1], self.radius]])
        return replace(self, newest=newest, stopped=min(self.stopped, self.last_seen))

    @property
    def centers(self) -> np.ndarray:
        """(m, 2) centres at the newest sights [m]."""
        return self.newest[:, 1:3]

    @property
    def has_walked(self) -> bool:
        """True once the mover is away from its first place, or was seen in it often enough."""
        return self.sights >= STAYED or float(np.hypot(*(self.centers[-1] - self.first))) > WALKED

    @property
    def is_walker(self) -> bool:
        """True once it has come from elsewhere, or was there: it is no wall where it stops."""
        return self.sights >= CONFIRMED and self.came > WALKED_IN

    @property
    def last_seen(self) -> float:
        """Stamp of the newest sight [s]."""
        return float(self.newest[-1, 0])

    @property
    def radius(self) -> float:
        """The largest of the newest radii: a mover is often half hidden [m]."""
        return float(self.newest[-4:, 3].max())

    @cached_property
    def _fit(self) -> tuple[np.ndarray, np.ndarray]:
        """Place (2,) [m] at the last sight and velocity (2,) [m/s], by a straight fit to the newest sights."""
        recent = self.newest[self.newest[:, 0] > self.last_seen - VELOCITY_SPAN - 1e-6]
        t, c = recent[:, 0], recent[:, 1:3]
        if len(t) < 2:
            return self.centers[-1], np.zeros(2)
        middle, from_middle = c.mean(axis=0), t - t.mean()
        velocity = (from_middle @ (c - middle)) / (from_middle @ from_middle)
        velocity *= min(1.0, FASTEST / max(float(np.hypot(*velocity)), 1e-9))
        velocity *= min(1.0, (self.sights - 1) / (CERTAIN - 1))
        return 0.5 * (c[-1] + middle + velocity * from_middle[-1]), velocity

    def motion_at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Place (2,) [m] and velocity (2,) [m/s] at a time [s]."""
        newest, velocity = self._fit
        return newest + velocity * (time - self.last_seen), velocity


def legs_of(tracks: list[Track]) -> tuple[np.ndarray, np.ndarray]:
    """(k, k) whether two tracks go together, and (k,) number of the person whose leg each is, the least of its tracks.

    Who stands between two others goes with both, and these not with one another.
    """
    together = np.array([[_go_together(one, other) for other in tracks] for one in tracks])
    numbers, (_, person) = np.array([track.number for track in tracks]), connected_components(together)
    return together, np.array([numbers[person == each].min() for each in person])


def _go_together(one: Track, other: Track) -> bool:
    """Returns whether two tracks were never more than a step apart and once beside one another: who passes was not."""
    _, i, k = np.intersect1d(one.newest[:, 0], other.newest[:, 0], return_indices=True)
    apart = np.hypot(*(one.newest[i, 1:3] - other.newest[k, 1:3]).T)
    return len(apart) > 0 and apart.max() < STEP and apart.min() < BESIDE


def _with_place(trail: np.ndarray, time: float, center: np.ndarray) -> np.ndarray:
    recent = trail[trail[:, 0] > time - TRAIL_TIME]
    if len(recent) and np.hypot(*(recent[-1, 1:] - center)) < TRAIL_STEP:
        return recent
    return np.vstack([recent, [time, *center]])


def with_clusters(
    tracks: tuple[Track, ...], number: int, time: float, clusters: list[Cluster]
) -> tuple[tuple[Track, ...], int, set[int]]:
    """The tracks after the clusters of a scan, the number of the next track, and which of the clusters are of a track.

    Each cluster continues the nearest track, and one that moves may begin its own, the first with `number`. The scan is
    of `time` [s].
    """
    places = [track.motion_at(time)[0] for track in tracks]
    pairs = sorted(
        (float(np.hypot(*(places[i] - cluster.center))), i, k)
        for i, track in enumerate(tracks)
        for k, cluster in enumerate(clusters)
        if cluster.moves or track.has_walked
    )
    after, taken = list(tracks), set[int]()
    for distance, i, k in pairs:
        speed = GATE_OF_WALKER if tracks[i].is_walker else GATE_SPEED
        gate = GATE + speed * (time - tracks[i].last_seen)
        if distance < gate and after[i] is tracks[i] and k not in taken:
            after[i] = tracks[i].seen_again(time, clusters[k])
            taken.add(k)
    for k, cluster in enumerate(clusters):
        if cluster.moves and k not in taken:
            unseen = Track(number, 0, cluster.center, np.zeros((0, 4)), np.zeros((0, 3)))
            after.append(unseen.seen_again(time, cluster))
            taken.add(k)
            number += 1
    return tuple(after), number, taken
