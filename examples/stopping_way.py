"""Prints the room that a stop takes: `stopping_way.py [PARAMETERS]`, by default for the robot as shipped."""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from collplan_core import Settings
from collplan_core.parameters.file import read_parameters

DELAYS = {"scan lost": 0.35, "pose lost": 0.2, "emergency stop": 0.09}
"""Longest time from a fault until zero is commanded, rounded up, simulated: docs/safety.md [s]."""

robot = Settings().with_values(read_parameters(Path(sys.argv[1])) if len(sys.argv) > 1 else {}).robot
speed = np.linspace(0.0, max(robot.max_speed, 1.2), 50)
plt.figure(figsize=(5, 3.5))
for event, delay in DELAYS.items():
    way = speed**2 / (2.0 * robot.max_acceleration) + speed * (delay + robot.velocity_lag)
    print(f"{event}: {way[-1]:.2f} m from {speed[-1]:.1f} m/s")
    plt.plot(speed, way, label=event)
plt.xlabel("speed when zero is commanded [m/s]")
plt.ylabel("way to rest [m]")
plt.title(f"a_max {robot.max_acceleration} m/s$^2$, lag {robot.velocity_lag} s")
plt.legend()
plt.tight_layout()
plt.savefig("stopping_way.png")
