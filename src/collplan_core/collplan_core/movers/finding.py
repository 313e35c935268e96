"""Sorts the returns of a scan into what stands, what moves and what is new, and follows what moves.

A return that lies inside the free space of an earlier scan, deeper than a margin, came there by moving. One on a
surface that an earlier scan showed at the same place stands, whatever another one saw there. All else is new: what
comes into view behind a tip, and what nothing vouches for. Who has walked in is remembered where it stopped, until a
scan shows the place free.
"""

import math
from bisect import bisect_left
from dataclasses import dataclass, replace

import numpy as np

from collplan_core.local_map.seen import SeenSurfaces
from collplan_core.movers.record import ALL_STANDS, MOVES, NEW, NO_MOVERS, STANDS, Movers, SortedReturns
from collplan_core.movers.tracks import (
    CONFIRMED,
    GROWTH_OF_FEW,
    LEAST_RADIUS,
    MOST_RADIUS,
    Cluster,
    Track,
    legs_of,
    with_clusters,
)
from collplan_core.movers.views import View, look_at_each, saw_free, view_of, without_surfaces
from collplan_core.parameters import MoverFinding
from collplan_core.scan import Scan
from collplan_core.state import State

AGES = (0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 0.8, 1.2, 2.0, 3.0)
"""Ages of the earlier scans compared [s]: short ones show what is fast, long ones what is slow or sets out."""
FARTHEST = 2.5
"""Returns beyond are not sorted: an error of the heading moves them by more than the margin [m]."""
IN_PLACE = 0.03
"""Distance from an earlier surface within which a return stayed in place [m]."""
JUMP, SKIPPED = 0.10, 3
"""Largest distance between neighbouring returns of one mover [m], and largest number of beams from one to the next."""
RIM, RIM_WIDTH = 0.05, 0.12
"""New returns beside a mover, so near to one another and in such a width, are its rim: the margin leaves it out [m]."""
FEWEST = 2
"""Returns of a mover: a single one may be mixed from two surfaces, and such a one does lie in free space."""
MOST_MOVING = 0.35
"""A scan of which a larger share of the beams shows motion shows a wrong pose."""
BEFORE_FIRST = (0.0, 0.1, 0.2, 0.3)
"""A mover's returns were new for so long before its first sight [s]."""
LOOKED_BACK = (CONFIRMED, 4, 8)
"""Numbers of sights at which a mover is taken out of what earlier scans vouch for: before it set out, it stood."""
AROUND = 0.15
"""A person's body around a leg: what is so near to who walked in is no wall that stood there [m]."""
MOST_STOPPED = 20
"""Movers that are remembered where they stopped; the oldest are forgotten first."""
SEEN_THROUGH = 0.5
"""A mover's place is seen through where its centre is free to this share of its radius."""


@dataclass(frozen=True, eq=False)
class MoverMemory:
    """Memory by which the next scan is sorted: earlier views, the oldest first, tracks, and the next track's number."""

    views: tuple[View, ...] = ()
    tracks: tuple[Track, ...] = ()
    number: int = 1


def find_movers(
    memory: MoverMemory, scan: Scan, noise: float, seen: SeenSurfaces, state: State, finding: MoverFinding
) -> tuple[SortedReturns, MoverMemory]:
    """Sorts the returns of a scan, and continues the tracks; returns also the memory for the next scan.

    `memory` is that after the scan before, `noise` the ranges' standard deviation [m], `state` the robot at the stamp.
    """
    view = view_of(scan, noise, seen, state.position)
    away = np.hypot(*(view.hits - view.beams[:, :2]).T)
    looked = view.is_hit & (away < FARTHEST)
    moved, stands = _compared(memory.views, view, looked, finding)
    kinds = np.where(stands, STANDS, NEW)
    kept = tuple(each for each in memory.views if 0.0 < seen.stamp - each.stamp <= AGES[-1] + 0.2)
    if not memory.tracks and not moved.any():
        nothing = SortedReturns(kinds, _movers([], seen.stamp, finding), ALL_STANDS.swept, ALL_STANDS.trails)
        return nothing, MoverMemory((*kept, view), (), memory.number)
    if moved.sum() <= MOST_MOVING * view.vouches.sum():
        kinds[moved | (looked & ~stands & _on_tracks(memory.tracks, view))] = MOVES
    groups = [each for each in _clusters(np.flatnonzero(kinds == MOVES), view) if len(each) >= FEWEST]
    kinds[kinds == MOVES] = NEW
    groups = [_with_rim(each, kinds, view) for each in groups]
    clusters = [Cluster(*_disc(each, view), moves=int(moved[each].sum()) >= FEWEST) for each in groups]
    tracks, number, followed = with_clusters(memory.tracks, memory.number, seen.stamp, clusters)
    for k in followed:
        kinds[groups[k]] = MOVES
    moves = kinds == MOVES
    newest = view._replace(stands=seen.joined & ~moves & ~np.roll(moves, -1))
    tracks = _expected(tracks, newest, kinds, finding)
    walkers = [each for each in tracks if each.is_walker]
    newest = without_surfaces(
        newest, np.array([(*each.centers[-1], each.radius + AROUND) for each in walkers]).reshape(-1, 3)
    )
    known = [track for track in tracks if track.sights >= CONFIRMED]
    swept = _swept(known)
    if any(track.sights in LOOKED_BACK and track.last_seen == seen.stamp for track in known):
        kept = tuple(without_surfaces(each, swept) for each in kept)
    returns = SortedReturns(kinds, _movers(known, seen.stamp, finding), swept, _trails(known))
    return returns, MoverMemory((*kept, newest), tracks, number)


def _compared(
    views: tuple[View, ...], view: View, looked: np.ndarray, finding: MoverFinding
) -> tuple[np.ndarray, np.ndarray]:
    """(n,) whether each return lies where an earlier scan saw free space, and whether it lies on an old surface."""
    moved, stands = np.zeros(len(looked), bool), np.zeros(len(looked), bool)
    if finding.standing_time == 0.0:
        stands |= looked
    chosen = _of_ages(views, view.stamp, (*AGES, finding.standing_time))
    n_old = sum(view.stamp - each.stamp > finding.standing_time - 1e-6 for each in chosen)
    # nearly all returns stand by the newest view that can tell so, and are then done
    for k, earlier in enumerate((*reversed(chosen[:n_old]), *chosen[n_old:])):
        reach = finding.margin, IN_PLACE if k < n_old else 0.0
        look_at_each(earlier[1:], view.hits, looked, moved, stands, reach)
    return moved & ~stands, stands


def _of_ages(views: tuple[View, ...], stamp: float, wanted: tuple[float, ...]) -> list[View]:
    """The views, the oldest first, whose ages are nearest to those wanted [s], none twice; of two as near the older."""
    nearest = set[int]()
    for age in wanted if views else ():
        if age < stamp - views[0].stamp + 0.03:
            i = min(bisect_left(views, -age, key=lambda each: each.stamp - stamp), len(views) - 1)
            older = i > 0 and abs(stamp - views[i - 1].stamp - age) <= abs(stamp - views[i].stamp - age)
            nearest.add(i - older)
    return [views[i] for i in sorted(nearest)]


def _on_tracks(tracks: tuple[Track, ...], view: View) -> np.ndarray:
    """(n,) whether each return is where a confirmed track is expected: what stops stays a mover."""
    found = np.zeros(len(view.hits), bool)
    for track in tracks:
        if track.has_walked:
            center, _ = track.motion_at(view.stamp)
            found |= np.hypot(*(view.hits - center).T) < track.radius + RIM
    return found


def _clusters(seeds: np.ndarray, view: View) -> list[np.ndarray]:
    """Runs of beams, around the turn where the scan closes, of which each return is near the one before."""
    n, runs = len(view.hits), list[list[int]]()
    for i in seeds.tolist():
        if runs and _are_near(runs[-1][-1], i, view):
            runs[-1].append(i)
        else:
            runs.append([i])
    if view.closed and len(runs) > 1 and _are_near(runs[-1][-1] - n, runs[0][0], view):
        runs[0] = runs.pop() + runs[0]
    return [np.array(run) for run in runs]


def _are_near(i: int, k: int, view: View) -> bool:
    return k - i <= SKIPPED and bool(np.hypot(*(view.hits[i] - view.hits[k])) < JUMP)


def _with_rim(cluster: np.ndarray, kinds: np.ndarray, view: View) -> np.ndarray:
    """A cluster with the new returns beside it."""
    beams, n = cluster.tolist(), len(kinds)
    for onward, end in ((-1, 0), (1, -1)):
        begin = beams[end]
        for _ in range(n):
            last, i = beams[end], beams[end] + onward
            if not view.closed and not 0 <= i < n:
                break
            i %= n
            near = np.hypot(*(view.hits[i] - view.hits[[last, begin]]).T) < (RIM, RIM_WIDTH)
            if i in beams or not view.is_hit[i] or kinds[i] != NEW or not near.all():
                break
            beams = [i, *beams] if onward < 0 else [*beams, i]
    return np.array(beams)


def _disc(beams: np.ndarray, view: View) -> tuple[np.ndarray, float]:
    """Centre (2,) and radius [m] of the disc that a cluster shows the front of."""
    first, last, sensor = view.hits[beams[0]], view.hits[beams[-1]], view.beams[beams[len(beams) // 2], :2]
    radius = min(max(0.5 * float(np.hypot(*(last - first))), LEAST_RADIUS), MOST_RADIUS)
    middle = 0.5 * (first + last) - sensor
    front = float(np.hypot(*(view.hits[beams] - sensor).T).min())
    return sensor + (front + radius) * middle / max(float(np.hypot(*middle)), 1e-9), radius


def _expected(tracks: tuple[Track, ...], newest: View, kinds: np.ndarray, finding: MoverFinding) -> tuple[Track, ...]:
    """The tracks that go on: seen lately, or of who stopped; none whose place is seen through, or is an old wall."""
    going = list[Track]()
    for track in tracks:
        late = newest.stamp - track.last_seen
        if late > 0.0:
            x, y = track.motion_at(newest.stamp)[0].tolist()
            if saw_free(newest, x, y, SEEN_THROUGH * track.radius):
                continue
        if late > finding.kept:
            near = np.hypot(*(newest.hits - track.centers[-1]).T) < track.radius
            forgotten = 0.0 < finding.memory < newest.stamp - min(track.stopped, track.last_seen)
            if not track.is_walker or forgotten or (near & (kinds == STANDS)).sum() >= FEWEST:
                continue
            track = track.where_it_stopped(newest.stamp)
        going.append(track)
    stopped = [each for each in going if each.stopped < math.inf]
    return tuple(each for each in going if each not in stopped[:-MOST_STOPPED])


def _swept(known: list[Track]) -> np.ndarray:
    """(m, 3) discs [m] in which movers were: at their sights, and before the first, when their returns were new."""
    discs = [np.zeros((0, 3))]
    for track in known:
        before = [track.motion_at(track.newest[0, 0] - age)[0] for age in BEFORE_FIRST]
        centers = np.vstack([track.centers, *before])
        discs.append(np.column_stack([centers, np.full(len(centers), track.radius + RIM)]))
    return np.concatenate(discs)


def _trails(known: list[Track]) -> np.ndarray:
    """(h, 3) discs [m] along the ways of tracks."""
    return np.vstack([np.zeros((0, 3)), *(np.insert(track.trail[:, 1:], 2, track.radius, axis=1) for track in known)])


def _movers(known: list[Track], stamp: float, finding: MoverFinding) -> Movers:
    if not known:
        return replace(NO_MOVERS, stamp=stamp)
    motions, (together, persons) = [track.motion_at(stamp) for track in known], legs_of(known)
    velocities = np.array([velocity for _, velocity in motions])
    return Movers(
        stamp,
        persons,
        np.array([place for place, _ in motions]),
        together @ velocities / together.sum(axis=1, keepdims=True),
        np.array([track.radius for track in known]),
        np.array([finding.growth + GROWTH_OF_FEW / track.sights for track in known]),
        np.array([track.last_seen for track in known]),
    )


def warm_up(scan: Scan, seen: SeenSurfaces, state: State, finding: MoverFinding) -> None:
    """Compiles the comparison by two scans of one place, so that the second scan of a node is not late."""
    _, memory = find_movers(MoverMemory(), scan, 0.0, seen, state, finding)
    find_movers(memory, scan, 0.0, seen._replace(stamp=seen.stamp + AGES[1]), state, finding)
    without_surfaces(memory.views[-1], np.zeros((1, 3)))
