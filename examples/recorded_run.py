"""Reads the recording of a run, without ROS: `recorded_run.py [RUN]`, by default runs/latest."""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from collplan_ros.run.reader import is_whole, messages

path = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/latest") / "run.mcap"
if not is_whole(path):
    print(f"{path}: has no end, it is cut off")
poses, commands = [], []
for topic, came, message in messages(path, ["mocap/odom", "cmd_vel"]):
    if topic == "mocap/odom":
        at, speed = message.pose.pose.position, message.twist.twist.linear
        poses.append((1e-9 * came, at.x, at.y, np.hypot(speed.x, speed.y)))
    else:
        commands.append((1e-9 * came, np.hypot(message.linear.x, message.linear.y)))
if not poses:
    sys.exit(f"{path}: holds no pose")
t, x, y, speed = np.array(poses).T
print(f"{path}: {len(poses)} poses and {len(commands)} commands in {t[-1] - t[0]:.1f} s")

figure, (way, speeds) = plt.subplots(1, 2, figsize=(9, 3.5), layout="constrained")
way.scatter(x, y, c=speed, s=4)
way.set_aspect("equal")
way.set_title("measured way [m], by speed")
speeds.step(*(np.array(commands).reshape(-1, 2) - [t[0], 0.0]).T, where="post", label="commanded")
speeds.plot(t - t[0], speed, label="measured")
speeds.set_xlabel("time [s]")
speeds.set_title("speed [m/s]")
speeds.legend()
figure.savefig("recorded_run.png")
