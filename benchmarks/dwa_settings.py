"""The dynamic window approach at the settings PythonRobotics publishes, for the robot and the scan measured here."""

import math
from typing import Any

import numpy as np
from logged import Logged

from collplan_core.parameters import Settings

MAX_SPEED, MIN_SPEED = 1.0, -0.5

RADIUS = Settings().robot.radius

DWA_SETTINGS: dict[str, Any] = {
    "max_speed": MAX_SPEED,
    "min_speed": MIN_SPEED,
    "max_yawrate": math.radians(40.0),
    "max_accel": 0.2,
    "max_dyawrate": math.radians(40.0),
    "velocity_resolution": 0.01,
    "yawrate_resolution": math.radians(0.1),
    "dt": 0.1,
    "predict_time": 3.0,
    "heading": 0.15,
    "clearance": 1.0,
    "velocity": 1.0,
    "base": [-RADIUS, -RADIUS, RADIUS, RADIUS],
}


def dwa_query(logged: Logged) -> dict[str, Any]:
    """Arguments of one step of the dynamic window in a logged state; the heading is the direction of travel."""
    velocity = logged.state.velocity
    speed = min(MAX_SPEED, float(np.hypot(*velocity)))
    yaw = math.atan2(velocity[1], velocity[0])
    points = logged.scan.points(logged.state, np.isfinite(logged.scan.ranges))
    return {
        "pose": [*logged.state.position.tolist(), yaw],
        "velocity": [speed, 0.0],
        "goal": np.asarray(logged.world.goal).tolist(),
        "points": points.tolist(),
    }
