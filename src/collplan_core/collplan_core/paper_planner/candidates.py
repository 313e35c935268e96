"""The sampling configuration space C = S x Theta x V. Paper: II-A."""

import math

import numpy as np

from collplan_core.jit import njit


@njit
def long_enough(segments: np.ndarray, number: np.ndarray, shortest: float) -> np.ndarray:
    """(m,) the pieces (m, 4) of frontiers at least so long [m]; all of them where none is.

    Between two touching round obstacles a notch of a few centimetres is seen as a frontier; to aim at it is to creep.
    """
    length = np.zeros(number[-1] + 1 if len(number) else 0)
    for k in range(len(segments)):
        length[number[k]] += math.hypot(segments[k, 2] - segments[k, 0], segments[k, 3] - segments[k, 1])
    kept = np.empty(len(segments), np.bool_)
    for k in range(len(segments)):
        kept[k] = length[number[k]] >= shortest
    return kept if kept.any() else np.ones(len(segments), np.bool_)


@njit
def sample_positions(segments: np.ndarray, number: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """S: floor(length / spacing) positions a frontier, at least one, at the centres of equal cells.

    Never at a frontier's ends, where the distance to a predicted boundary is 0 by construction.

    Args:
        segments: (m, 4) straight pieces, those of one frontier in sequence [m].
        number: (m,) frontier of each piece.
        spacing: dl [m].

    Returns:
        positions (p, 2) [m] and the piece each lies on (p,).
    """
    m = len(segments)
    length = np.empty(m)
    total = 0.0
    for k in range(m):
        length[k] = math.hypot(segments[k, 2] - segments[k, 0], segments[k, 3] - segments[k, 1])
        total += length[k]
    positions = np.empty((m + int(total / spacing), 2))
    piece = np.empty(len(positions), np.int64)
    count, first = 0, 0
    while first < m:
        last = first
        whole = length[first]
        while last + 1 < m and number[last + 1] == number[first]:
            last += 1
            whole += length[last]
        cells = max(1, int(math.floor(whole / spacing + 1e-9)))
        k, before = first, 0.0
        for i in range(cells):
            along = (i + 0.5) * whole / cells
            while k < last and along > before + length[k]:
                before += length[k]
                k += 1
            share = (along - before) / max(length[k], 1e-12)
            positions[count, 0] = segments[k, 0] + share * (segments[k, 2] - segments[k, 0])
            positions[count, 1] = segments[k, 1] + share * (segments[k, 3] - segments[k, 1])
            piece[count] = k
            count += 1
        first = last + 1
    return positions[:count], piece[:count]


@njit
def speed_counts(piece: np.ndarray, number: np.ndarray, n_speeds: int, as_printed: bool) -> np.ndarray:
    """(p,) N_v of each position: n_speeds, or as printed floor(length / dl): the positions on its frontier."""
    counts = np.full(len(piece), n_speeds, np.int64)
    if as_printed:
        for i in range(len(piece)):
            counts[i] = 0
            for j in range(len(piece)):
                counts[i] += number[piece[i]] == number[piece[j]]
    return counts


@njit
def product(
    kept: np.ndarray, heads: np.ndarray, piece: np.ndarray, counts: np.ndarray, max_speed: float
) -> tuple[np.ndarray, np.ndarray]:
    """The candidates themselves: each kept position at rest once, then every kept direction at every speed.

    Args:
        kept: (p,) positions that survive.
        heads: (m, n_directions) directions that survive on each frontier piece.
        piece: (p,) piece of each position.
        counts: (p,) N_v of each position.
        max_speed: v_max [m/s].

    Returns:
        the position of each candidate (c,) and its velocity (c, 2) [m/s].
    """
    n_directions = heads.shape[1]
    size = 0
    for i in range(len(kept)):
        if kept[i]:
            size += 1 + counts[i] * int(heads[piece[i]].sum())
    at = np.empty(size, np.int64)
    velocity = np.zeros((size, 2))
    c = 0
    for i in range(len(kept)):
        if not kept[i]:
            continue
        at[c] = i
        c += 1
        for head in range(n_directions):
            if not heads[piece[i], head]:
                continue
            theta = 2.0 * math.pi * head / n_directions
            for step in range(1, counts[i] + 1):
                speed = max_speed * step / counts[i]
                at[c] = i
                velocity[c, 0], velocity[c, 1] = speed * math.cos(theta), speed * math.sin(theta)
                c += 1
    return at, velocity
