"""A planner of your own in a simulated robot: to the frontier from which the rest of the way looks shortest."""

import matplotlib.pyplot as plt
import numpy as np

from collplan_core import NoPlan, Planner, Settings, load_world, register, timed_path, world_segments
from omnipuck_sim import run_trial


def greedy(memory, local_map, state, goal, settings, deadline=None):
    """A straight line within the free space, at half of v_max."""
    if local_map.contains(goal[None])[0]:
        aim = goal
    else:
        frontiers = local_map.segments.reshape(-1, 2, 2).mean(axis=1)
        if not len(frontiers):
            raise NoPlan("no frontier to go to")
        rest = np.hypot(*(frontiers - state.position).T) + np.hypot(*(goal - frontiers).T)
        aim = frontiers[rest.argmin()]
    way = aim - state.position
    duration = max(np.hypot(*way) / (0.5 * settings.robot.max_speed), 0.1)
    share = np.linspace(0.0, 1.0, 50)
    positions = state.position + np.outer(share, way)
    return timed_path(state.stamp, state.stamp + duration * share, positions, np.tile(way / duration, (50, 1))), memory


register("greedy", Planner(greedy, map_period=0.1))
world = load_world("random:7")
result = run_trial(world, Settings().with_values({"planner.strategy": "greedy"}), seed=1)
print(result)

plt.figure(figsize=(5, 5))
plt.plot(*world_segments(world).reshape(-1, 2, 2).transpose(2, 1, 0), color="black")
for positions in result.plans[::5]:
    plt.plot(*positions.T, color="tab:blue", linewidth=0.6)
plt.plot(*result.trajectory[:, 1:3].T, color="tab:orange", label=f"greedy: {result.arrival_time:.2f} s")
plt.plot(*world.goal, "k*", markersize=12)
plt.axis("equal")
plt.legend(loc="lower left")
plt.savefig("own_planner.png")
