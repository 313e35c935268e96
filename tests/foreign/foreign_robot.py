"""The process of a robot that is not ours, what it needs to run, and what its user would write down of it."""

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

from real_messages import INSTALLED, MODULES

from rooms import RADIUS, Room, write_world

PROGRAM = Path(__file__).with_name("irsim_robot.py")
WATCHDOG = 0.5
"""Silence after which the base stops by itself [s]."""
PERIOD = 0.02
"""Period of its odometry [s]."""
LATE = 0.3
"""Delay of commands in the fault "late" [s]."""
PARAMETERS = {
    "robot": {"radius": RADIUS, "mass": 3.0, "max_speed": 0.8, "max_acceleration": 1.5, "velocity_lag": 0.1},
    "cap": {"speed": 0.8},
    "limits": {"impact_speed": 0.8},
    "mocap": {"format": "odometry", "topic": "/odom", "frame": "odom", "localised": True},
}


def missing() -> str:
    """Says why it cannot run here, as packages are missing; empty where it can."""
    lacks = [name for name in ("tf2_msgs", "irsim") if find_spec(name) is None and not (MODULES / name).is_dir()]
    return f"missing: {', '.join(lacks)}: `make messages`, `make setup`" if lacks else ""


def environment() -> dict[str, str]:
    """Variables under which its program finds its messages, and so do the nodes of bringup."""
    found = {"MPLBACKEND": "agg"}
    if MODULES.is_dir():
        # type support opens its libraries by their names
        paths = {"PYTHONPATH": MODULES, "AMENT_PREFIX_PATH": INSTALLED, "LD_LIBRARY_PATH": INSTALLED / "lib"}
        found |= {key: os.pathsep.join(filter(None, [str(path), os.environ.get(key)])) for key, path in paths.items()}
    return found


def start(room: Room, world: Path) -> subprocess.Popen[bytes]:
    """Starts it in a room, which is written as a file."""
    command = [sys.executable, str(PROGRAM), str(write_world(room, world)), "1"]
    return subprocess.Popen(command, stderr=subprocess.DEVNULL)
