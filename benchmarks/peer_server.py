"""Program for the peers' environment: reads requests from stdin, times one round of a peer, answers on stdout."""

import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from answering import serve
from timing import time_each

BEAMS, RANGE_MIN, RANGE_MAX = 360, 0.02, 5.0


def irsim_scene(world: dict[str, Any], radius: float, max_speed: float, step_time: float) -> dict[str, Any]:
    """Configuration of ir-sim for a world, with an omnidirectional disc that has a LIDAR without noise."""
    x0, y0, x1, y1 = world["bounds"]
    corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
    shapes = [{"name": "polygon", "vertices": polygon} for polygon in world["polygons"]]
    shapes += [{"name": "linestring", "vertices": [corners[i - 1], corners[i]]} for i in range(4)]
    lidar = {"name": "lidar2d", "number": BEAMS, "angle_range": 2 * math.pi, "noise": False}
    robot = {
        "kinematics": {"name": "omni"},
        "shape": {"name": "circle", "radius": radius},
        "state": [*world["start"], 0],
        "goal": [*world["goal"], 0],
        "vel_max": [max_speed] * 2,
        "vel_min": [-max_speed] * 2,
        "sensors": [{**lidar, "range_min": RANGE_MIN, "range_max": RANGE_MAX}],
    }
    arena = {"width": x1 - x0, "height": y1 - y0, "offset": [x0, y0], "step_time": step_time}
    obstacles = [{"shape": shape, "state": [0, 0, 0]} for shape in shapes]
    return {"world": {**arena, "collision_mode": "contact"}, "robot": [robot], "obstacle": obstacles}


def environment(step_time: float, scene: dict[str, Any]) -> Any:
    """ir-sim's environment for a scene: its world, and the robot's radius and max_speed."""
    import irsim

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(yaml.safe_dump(irsim_scene(step_time=step_time, **scene)), encoding="utf-8")
        return irsim.make(str(path), headless=True, log_level="ERROR")


def scan(scene: dict[str, Any], poses: list[list[float]]) -> list[float]:
    """Wall time of Lidar2D.step at each pose [us]."""
    lidar = environment(0.05, scene).robot.sensors[0]
    return time_each(lidar.step, [np.array(pose)[:, None] for pose in poses])


def trial(scene: dict[str, Any], path: list[list[float]], step_time: float) -> list[float]:
    """Wall time of steps that move the robot along a path [us]; each command leads from the current pose to a point."""
    env = environment(step_time, scene)
    points = [np.array(point)[:, None] for point in path]
    return [sum(time_each(lambda point: env.step((point - env.robot.state[:2]) / step_time), points))]


def dwa_round(settings: dict[str, Any], queries: list[dict[str, Any]]) -> list[float]:
    """Wall time of planning for each query [us]."""
    import dwa

    config = dwa.Config(**settings)
    names = ("pose", "velocity", "goal")
    cases = [(*(tuple(each[name]) for name in names), np.array(each["points"], dtype=np.float32)) for each in queries]
    return time_each(lambda case: dwa.planning(*case, config), cases)


if __name__ == "__main__":
    serve({"scan": scan, "trial": trial, "dwa": dwa_round})
