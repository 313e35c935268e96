"""Program for the peers' environment: reads requests from stdin, times one round of a peer, answers on stdout."""

import json
import math
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import yaml

BEAMS, RANGE_MIN, RANGE_MAX = 360, 0.02, 5.0

scene: dict[str, Any] = {}


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


def make_scene(step_time: float) -> Any:
    """ir-sim's environment for the world that was set last."""
    import irsim

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(yaml.safe_dump(irsim_scene(step_time=step_time, **scene)), encoding="utf-8")
        return irsim.make(str(path), headless=True, log_level="ERROR")


def set_world(**description: Any) -> dict[str, Any]:
    """Set the world that scans and trials take place in; returns the beams' directions [rad]."""
    scene.clear()
    scene.update(description)
    lidars["scene"] = make_scene(0.05)
    lidar = lidars["scene"].robot.sensors[0]
    return {"angles": lidar.angle_list.tolist()}


lidars: dict[str, Any] = {}


def scan(poses: list[list[float]]) -> dict[str, Any]:
    """Wall time of Lidar2D.step at each pose [us], and the last ranges."""
    lidar = lidars["scene"].robot.sensors[0]
    times = []
    for pose in poses:
        state = np.array(pose)[:, None]
        started_at = time.perf_counter_ns()
        lidar.step(state)
        times.append((time.perf_counter_ns() - started_at) / 1e3)
    return {"us": times, "ranges": lidar.range_data.tolist()}


def trial(path: list[list[float]], step_time: float) -> dict[str, Any]:
    """Wall time of steps that move the robot along a path [s]; each command leads from the current pose to a point."""
    env = make_scene(step_time)
    started_at = time.perf_counter()
    for point in path:
        env.step((np.array(point)[:, None] - env.robot.state[:2]) / step_time)
    wall = time.perf_counter() - started_at
    end = env.robot.state[:2, 0].tolist()
    return {"s": wall, "steps": len(path), "end": end}


def dwa_round(settings: dict[str, Any], queries: list[dict[str, Any]]) -> dict[str, Any]:
    """Wall time of planning [us] and number of candidates for each query."""
    import dwa

    config = dwa.Config(**settings)
    times, candidates = [], []
    for query in queries:
        points = np.array(query["points"], dtype=np.float32)
        pose, velocity, goal = tuple(query["pose"]), tuple(query["velocity"]), tuple(query["goal"])
        started_at = time.perf_counter_ns()
        dwa.planning(pose, velocity, goal, points, config)
        times.append((time.perf_counter_ns() - started_at) / 1e3)
        window = dwa.DynamicWindow(velocity, config)
        candidates.append(len(window.possible_v) * len(window.possible_w))
    return {"us": times, "candidates": candidates}


REQUESTS = {"world": set_world, "scan": scan, "trial": trial, "dwa": dwa_round}


def main() -> None:
    """Answer until stdin ends."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # stdout carries answers alone; what a peer prints goes to stderr
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer = {"result": REQUESTS[request.pop("what")](**request)}
        except Exception as error:  # any error of a peer is reported as the reason to skip it
            answer = {"error": f"{type(error).__name__}: {error}"}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
