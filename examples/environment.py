"""Two policies in the environment of gymnasium: a strategy of collplan, and a few lines of one's own."""

import gymnasium
import matplotlib.pyplot as plt
import numpy as np

import collplan_gym

FASTEST = 1.2
"""v_max as shipped [m/s]."""


def toward_open_space(observation, info):
    """The velocity along the beam that leads towards the goal and is free for long."""
    ranges = np.minimum(observation["scan"], 0.5)
    angles = np.linspace(-np.pi, np.pi, len(ranges), endpoint=False)
    width = len(ranges) // 12
    clear = np.array([np.roll(ranges, shift) for shift in range(-width, width + 1)]).min(axis=0)
    goal = np.arctan2(observation["goal"][1], observation["goal"][0])
    best = angles[np.argmax(clear * (1.2 + np.cos(angles - goal)))]
    return 0.5 * FASTEST * np.array([np.cos(best), np.sin(best)], dtype=np.float32)


env = gymnasium.make("collplan/Bounce-v0", world="random:7")
plt.figure(figsize=(5, 3.5))
for name, policy in (("bounce", collplan_gym.PlannerPolicy("bounce")), ("towards open space", toward_open_space)):
    observation, info = env.reset(seed=1)
    begin, rows, contacts, over = info["stamp"], [], 0, False
    while not over:
        rows.append((info["stamp"] - begin, np.hypot(*observation["goal"])))
        observation, reward, arrived, late, info = env.step(policy(observation, info))
        contacts, over = contacts + info["contacts"], arrived or late
    print(f"{name}: {'arrived' if arrived else 'late'} after {info['stamp'] - begin:.2f} s, {contacts} contacts")
    plt.plot(*np.array(rows).T, label=f"{name}, {contacts} contacts")
plt.xlabel("time [s]")
plt.ylabel("distance to the goal [m]")
plt.legend()
plt.tight_layout()
plt.savefig("environment.png")
