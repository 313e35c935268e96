"""warm_up compiles what the nodes will call: a first plan that waited for the compiler would be seconds late."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from numba.core.dispatcher import Dispatcher

SCRIPT = """
import sys; sys.path.insert(0, sys.argv[1])
from test_warm_up import compiled_beyond_warm_up
print(*compiled_beyond_warm_up())
"""


def signatures() -> dict[str, int]:
    """How many variants of each compiled function of the core there are."""
    modules = [m for name, m in list(sys.modules.items()) if name.startswith("collplan_core")]
    found = [v for m in modules for v in vars(m).values() if isinstance(v, Dispatcher)]
    return {f"{d.py_func.__module__}.{d.py_func.__name__}": len(d.signatures) for d in found}


def compiled_beyond_warm_up() -> list[str]:
    """What cycles of both nodes compile after warm_up, with records as they come from messages, and whole trials."""
    from rclpy.serialization import serialize_message

    from collplan_core.control.follow import ControllerMemory, follow
    from collplan_core.local_map import build_local_map
    from collplan_core.loop.motion_watch import MotionWatch
    from collplan_core.loop.recovery import Recovery
    from collplan_core.parameters import Lidar, Settings
    from collplan_core.planners import planner_for
    from collplan_core.poses.pose_filter import FRESH, PoseSample, filter_pose
    from collplan_core.state import State
    from collplan_core.strategies import TIME_TO_GOAL
    from collplan_core.time_to_goal_planner.way_to_goal import way_to_goal
    from collplan_core.warm_up import warm_up
    from collplan_core.worlds import load_world
    from collplan_core.worlds.raycast import simulate_scan
    from collplan_core.worlds.spinning_lidar import sweeps_of
    from collplan_ros.messages import conversions, reading
    from collplan_ros.messages.cloud_reading import plan_from_message
    from collplan_ros.messages.planner_clouds import plan_to_message
    from collplan_ros.messages.raw_reading import state_from_bytes
    from fake_robot import LIDAR, hall
    from omnipuck_sim.trial import run_trial

    warm_up()
    before, settings = signatures(), Settings()
    memory, watch, recovery, found = FRESH, MotionWatch(), Recovery(), []
    for k in range(60):
        # there and back, as from a wall, and in the end elsewhere
        now, x = 0.01 * k, 5.0 if k == 59 else 0.01 * min(k, 60 - k)
        result, memory = filter_pose(memory, PoseSample(now, np.array([x, 0.0]), 0.1), now, settings)
        found += [result.impact] if result.impact is not None else []
        if result.state is not None:
            watch.take_pose(result.state, now, True, settings)
            recovery.commanded(result.state.velocity, now)
            recovery.moved(result.state, now, settings)
    assert len(found) == 1
    assert result.refused == "leap"
    state = State(1.0, np.zeros(2), np.zeros(2), 0.1)
    raw = serialize_message(conversions.state_to_odometry(state, "map", "base"))
    state = state_from_bytes(raw, "map", "base")
    scan = conversions.scan_to_message(simulate_scan(hall(0.1), state, LIDAR), "base")
    local_map = build_local_map(reading.scan_from_message(scan, "base"), state, settings.robot, settings.local_map)
    sweeps = sweeps_of(hall(0.1), Lidar(sensor="low_cost"), 0)
    scans = [sweeps.take_pose(State(0.01 * k, state.position, state.velocity, state.yaw)) for k in range(12)]
    assert scans[-1] is not None
    for strategy in ("harness", *TIME_TO_GOAL):
        chosen = settings.with_values({"planner.strategy": strategy})
        memory = None
        for goal in ([2.0, 0.0], [2.0, 0.0], [0.2, 0.1]):
            planner = planner_for(strategy)
            plan, memory = planner.plan(memory, local_map, state, np.array(goal), chosen)
            plan = plan_from_message(plan_to_message(plan, "map"), "map")
            command, _ = follow(ControllerMemory(), plan, local_map, state, 1.1, chosen)
            watch.commanded(command, 1.1)
    nowhere = replace(memory.paths, waypoint=np.full_like(memory.paths.waypoint, -1))
    way_to_goal(memory.remembered, nowhere, state.position, chosen)
    for world, strategy in {"serpentine:3": "harness", "pillars:1": "tolerate", "corridor": "high_risk"}.items():
        run_trial(load_world(world), settings.with_values({"planner.strategy": strategy}), seed=1)
    return [name for name, count in signatures().items() if count != before.get(name, 0)]


def test_first_cycle_of_the_nodes_compiles_nothing():
    command = [sys.executable, "-c", SCRIPT, str(Path(__file__).parent)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert run.stdout.split() == []
