"""Whether pruning keeps an aim that leads on wherever there is one: the paper's contribution 3, by brute force.

    .venv/bin/python studies/pruning.py

A map is the local map of a robot at a random free place of a generated world, with a random goal outside of F that it
can reach. Beyond F, what is truly free for the disc falls apart into regions that do not touch outside of F; those
smaller than LEAST are notches that lead nowhere. A region is behind an aim where it comes within REACH of it on the
unseen side of its frontier. An aim leads on where a region is behind it, and leads to the goal where the goal's own
region is. Each is asked of all aims, and of those that pruning keeps. Obstacles of `random` are convex, those of the
other families are walls with turns. Prints a table for docs/paper.md. Simulated.
"""

import argparse
from itertools import count

import numpy as np
import shapely
from scipy import ndimage

from collplan_core.local_map import build_local_map
from collplan_core.paper_planner.sampling_space import sampling_space
from collplan_core.parameters import Settings
from collplan_core.state import State
from collplan_core.worlds import load_world
from collplan_core.worlds.raycast import simulate_scan
from collplan_core.worlds.route import free_space

FAMILIES = {"convex": ("random",), "walls": ("serpentine", "u", "z", "l", "baffles")}
FIRST, SEED = 5000, 38
PLACES = 20
"""Maps of one world."""
SPACING, REACH, LEAST = 0.02, 0.04, 0.01
"""Of the grid on which regions are found; how near to an aim a region is behind it [m]; least area of one [m^2]."""
SETTINGS = Settings()
PLANNING = {
    "all": SETTINGS.with_values({"planner.position_pruning": False, "planner.velocity_pruning": False}).planner,
    "kept": SETTINGS.planner,
}


class Ground:
    """What is truly free for the disc in a world, on a grid."""

    def __init__(self, name: str) -> None:
        """Of the world called `name`."""
        self.world = load_world(name)
        left, bottom, right, top = self.world.bounds
        xs, ys = np.arange(left, right, SPACING), np.arange(bottom, top, SPACING)
        self.nodes = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1)
        self.free = shapely.contains_xy(free_space(self.world, SETTINGS.robot.radius), *np.moveaxis(self.nodes, -1, 0))
        self.parts = ndimage.label(self.free)[0]

    def regions(self, seen: np.ndarray) -> np.ndarray:
        """(nx, ny) the number of the free region outside of what is seen, 0 elsewhere and where that is a notch."""
        regions = ndimage.label(self.free & ~seen)[0]
        small = np.bincount(regions.ravel()) * SPACING**2 < LEAST
        return np.where(small[regions], 0, regions)


def behind(aims: np.ndarray, outward: np.ndarray, ground: Ground, regions: np.ndarray) -> list[set[int]]:
    """The regions behind each aim (n, 2), whose frontier has unseen space in the direction `outward` (n, 2)."""
    found, origin = [], ground.nodes[0, 0]
    for aim, out in zip(aims, outward, strict=True):
        i, j = np.rint((aim - origin) / SPACING).astype(int)
        rows, columns = slice(max(i - 3, 0), i + 4), slice(max(j - 3, 0), j + 4)
        off = ground.nodes[rows, columns] - aim
        near = (np.hypot(*np.moveaxis(off, -1, 0)) <= REACH) & (off @ out > 0.0)
        found.append(set(regions[rows, columns][near].tolist()) - {0})
    return found


def outward_of(aims: np.ndarray, segments: np.ndarray) -> np.ndarray:
    """(n, 2) unit direction into unseen space, to the right of the frontier segment (m, 4) that each aim lies on."""
    begin, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    length = np.maximum(np.hypot(*along.T), 1e-9)
    share = np.clip(((aims[:, None] - begin) * along).sum(axis=2) / length**2, 0.0, 1.0)
    nearest = np.hypot(*np.moveaxis(aims[:, None] - begin - share[..., None] * along, -1, 0)).argmin(axis=1)
    return np.stack([along[:, 1], -along[:, 0]], axis=1)[nearest] / length[nearest, None]


def one_map(ground: Ground, random: np.random.Generator) -> dict[str, bool] | None:
    """Whether all aims, and those kept, lead on and to the goal; None where there is nothing to compare."""
    free = np.argwhere(ground.free)
    position = ground.nodes[tuple(free[random.integers(len(free))])]
    state = State(0.0, position, np.zeros(2), 0.0)
    scan = simulate_scan(ground.world, state, SETTINGS.lidar)
    local_map = build_local_map(scan, state, SETTINGS.robot, SETTINGS.local_map)
    seen = local_map.contains(ground.nodes.reshape(-1, 2)).reshape(ground.free.shape)
    regions = ground.regions(seen)
    here = ground.parts[tuple(np.rint((position - ground.nodes[0, 0]) / SPACING).astype(int))]
    goals = np.argwhere((regions > 0) & (ground.parts == here))
    if not len(goals) or not len(local_map.segments):
        return None
    goal_node = tuple(goals[random.integers(len(goals))])
    goal = ground.nodes[goal_node]
    result = {}
    for name, planner in PLANNING.items():
        space = sampling_space(local_map, goal - local_map.position, SETTINGS.robot.max_speed, planner)
        aims = space.positions + local_map.position
        found = behind(aims, outward_of(aims, local_map.segments), ground, regions)
        result[f"{name} on"] = any(found)
        result[f"{name} goal"] = any(regions[goal_node] in each for each in found)
        result[name] = len(aims)
    return result


def main() -> None:
    """Prints a table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--maps", type=int, default=5000, help="maps of each kind of obstacles")
    wanted = parser.parse_args().maps
    print("| obstacles | maps | aims | kept | lead on | lost | lead to the goal | lost |\n|---|" + "---|" * 7)
    for kind, families in FAMILIES.items():
        rows, lost = [], []
        for seed in count(FIRST):
            name = f"{families[seed % len(families)]}:{seed}"
            ground, random = Ground(name), np.random.default_rng([SEED, seed])
            for place in range(PLACES):
                row = one_map(ground, random)
                if row is not None:
                    rows.append(row)
                    if row["all goal"] and not row["kept goal"]:
                        lost.append(f"{name}/{place}")
            if len(rows) >= wanted:
                break
        rows = rows[:wanted]
        total = {key: sum(row[key] for row in rows) for key in rows[0]}
        gone = {what: sum(row[f"all {what}"] and not row[f"kept {what}"] for row in rows) for what in ("on", "goal")}
        sizes = " | ".join(f"{total[each] / len(rows):.1f}" for each in ("all", "kept"))
        ends = " | ".join(f"{total[f'all {what}']} | {gone[what]}" for what in ("on", "goal"))
        print(f"| {kind} | {len(rows)} | {sizes} | {ends} |", flush=True)
        print("lost:", ", ".join(lost[:10]))


if __name__ == "__main__":
    main()
