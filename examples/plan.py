"""One plan: what the robot sees from its start, and where it plans to go."""

from pathlib import Path

import matplotlib.pyplot as plt

from collplan_core import Settings, State, build_local_map, load_world, plan_once, simulate_scan, world_segments

world = load_world(str(Path(__file__).with_name("room.yaml")))
# the planner looks as far, by time_to_goal.half_side
settings = Settings().with_values({"planner.strategy": "bounce", "local_map.half_side": 1.2})
state = State.at_rest(world.start)
scan = simulate_scan(world, state, settings.lidar)
local_map = build_local_map(scan, state, settings.robot, settings.local_map)
plan, _ = plan_once(scan, state, world.goal, settings)
print(plan)

plt.figure(figsize=(6, 4.5))
plt.plot(*world_segments(world).reshape(-1, 2, 2).transpose(2, 1, 0), color="black")
plt.fill(*local_map.border_points.T, color="tab:green", alpha=0.2, label="free space")
for x0, y0, x1, y1 in local_map.segments:
    plt.plot([x0, x1], [y0, y1], color="tab:green", linestyle="--")
plt.scatter(*plan.positions.T, c=plan.times, s=6, label="plan")
plt.scatter(*plan.contacts.points.T, marker="D", color="tab:red", label="planned contact")
plt.plot(*world.goal, "k*", markersize=12, label="goal")
plt.axis("equal")
plt.legend(loc="upper center", bbox_to_anchor=(0.5, 1.12), ncols=4, fontsize="small")
plt.savefig("plan.png")
