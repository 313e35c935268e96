"""A sweep: how much time a bounce saves, by how fast the robot can accelerate."""

import matplotlib.pyplot as plt

from collplan_core import Settings, load_world
from omnipuck_sim import run_trial

world = load_world("serpentine:2")
accelerations, seeds = (1.0, 1.5, 3.0), range(1)
plt.figure(figsize=(5, 3.5))
for strategy in ("avoid", "bounce"):
    means = []
    for max_acceleration in accelerations:
        values = {"planner.strategy": strategy, "robot.max_acceleration": max_acceleration}
        times = [run_trial(world, Settings().with_values(values), seed).arrival_time for seed in seeds]
        means.append(sum(times) / len(times))
        print(f"{strategy}, a_max {max_acceleration} m/s^2: {means[-1]:.2f} s")
    plt.plot(accelerations, means, "o-", label=strategy)
plt.xlabel("largest acceleration [m/s$^2$]")
plt.ylabel("arrival time [s]")
plt.ylim(bottom=0.0)
plt.legend()
plt.tight_layout()
plt.savefig("sweep.png")
