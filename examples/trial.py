"""Two strategies in one room: the way of each, and where it touched."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from collplan_core import Settings, load_world, world_segments
from omnipuck_sim import run_trial

world = load_world(str(Path(__file__).with_name("room.yaml")))
plt.figure(figsize=(6, 4.5))
plt.plot(*world_segments(world).reshape(-1, 2, 2).transpose(2, 1, 0), color="black")
for strategy in ("avoid", "bounce"):
    result = run_trial(world, Settings().with_values({"planner.strategy": strategy}), seed=1)
    print(result)
    (line,) = plt.plot(*result.trajectory[:, 1:3].T, label=f"{strategy}: {result.arrival_time:.2f} s")
    points = np.array([impact.point for impact in result.impacts]).reshape(-1, 2)
    plt.scatter(*points.T, marker="x", color=line.get_color())
plt.plot(*world.goal, "k*", markersize=12)
plt.axis("equal")
plt.legend(loc="upper center", bbox_to_anchor=(0.5, 1.12), ncols=2)
plt.savefig("trial.png")
