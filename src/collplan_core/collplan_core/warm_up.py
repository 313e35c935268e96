"""Compiles everything once, so that the first cycle is not late.

`python -m collplan_core.warm_up` at set-up, `warm_up()` in a node before it says that it is ready.
"""

import signal
from dataclasses import replace

import numpy as np

from collplan_core.command import FREE_SPACE, Command
from collplan_core.control.follow import ControllerMemory, boundary_reference, follow
from collplan_core.learning import drive_learner
from collplan_core.local_map import LocalMap, build_local_map
from collplan_core.local_map.contact_point import find_contact, passes_through
from collplan_core.local_map.seen import seen_surfaces
from collplan_core.loop import motion_watch
from collplan_core.loop.delay_prediction import motion_under_way
from collplan_core.loop.mover_guard import kept_off
from collplan_core.loop.sensed_scans import PlacedScan
from collplan_core.movers import finding
from collplan_core.movers.coverage import with_view
from collplan_core.movers.record import NO_MOVERS
from collplan_core.paper_planner.foreseen_contacts import foreseen_contacts
from collplan_core.parameters import Settings
from collplan_core.planners import planner_for
from collplan_core.poses import pose_filter
from collplan_core.scans import plausibility as scan_plausibility
from collplan_core.scans import wall_lines
from collplan_core.state import State
from collplan_core.time_to_goal_planner.boundary_memory.field import FIRST_SIDE
from collplan_core.time_to_goal_planner.boundary_memory.update import remember
from collplan_core.time_to_goal_planner.tried_gaps import gap_on_the_way
from collplan_core.time_to_goal_planner.way_to_goal import way_to_goal
from collplan_core.worlds import load_world, spinning_lidar
from collplan_core.worlds.raycast import simulate_scan


def warm_up() -> None:
    """One pass of the whole loop in a shipped arena: poses, scan, map, plan, control."""
    pose_filter.warm_up()
    spinning_lidar.warm_up()
    motion_watch.warm_up()
    drive_learner.warm_up()
    settings = Settings()
    world = load_world("corridor")
    assert world.start is not None, "the shipped arenas have a start"
    assert world.goal is not None, "the shipped arenas have a goal"
    state = State(0.0, np.array(world.start), np.array([0.1, 0.0]), 0.0)
    scan = simulate_scan(world, state, settings.lidar)
    scan_plausibility.warm_up(scan, seen_surfaces(scan, state), state, settings.limits)
    wall_lines.warm_up(scan)
    finding.warm_up(scan, seen_surfaces(scan, state), state, settings.movers)
    with_view(None, seen_surfaces(scan, state), state, settings.robot.radius)
    local_map = build_local_map(scan, state, settings.robot, settings.local_map)
    motion_under_way(state, np.zeros((1, 3)), 0.01, 0.01, local_map, settings)
    onto = Command(np.array([settings.robot.max_speed, 0.0]), 0.0, FREE_SPACE, np.zeros(2))
    wary = settings.with_values({"limits.emerging_speed": settings.robot.max_speed})
    kept_off(onto, state, NO_MOVERS, PlacedScan(scan, state, local_map), wary)
    for strategy in ("high_risk", "harness"):
        chosen, planner = settings.with_values({"planner.strategy": strategy}), planner_for(strategy)
        plan, memory = planner.plan(None, local_map, state, world.goal, chosen)
        planner.plan(memory, local_map, state, state.position + 0.01, chosen)
    at_rest, onward = np.tile(state.position, (2, 1)), np.tile(plan.aim_velocity, (2, 1))
    foreseen_contacts(local_map, np.array([0.0, 1.0]), at_rest, onward, settings)
    wall = local_map.border_points[np.argmax(local_map.surface >= 0)]
    into_wall = np.linspace(state.position, state.position + 1.2 * (wall - state.position), len(plan.times))
    _warm_up_contact(into_wall, plan.times, local_map, settings)
    toward = replace(plan, positions=into_wall)
    for each in (plan, toward):
        follow(ControllerMemory(), each, local_map, state, plan.stamp, settings)
    _warm_up_time_to_goal(local_map, state, world.goal)


def _warm_up_contact(path: np.ndarray, times: np.ndarray, local_map: LocalMap, settings: Settings) -> None:
    """Compiles the functions for a path (n, 2) into a wall, in planning and in following."""
    contact = find_contact(path, local_map)
    assert contact is not None, "it leads into the wall"
    passes_through(path, contact, local_map)
    boundary_reference(times, path, contact, local_map, settings)
    foreseen_contacts(local_map, times, path, np.gradient(path, axis=0), settings)


def _warm_up_time_to_goal(local_map: LocalMap, state: State, goal: np.ndarray) -> None:
    """Two cycles of each strategy with kernels of its own: the second one begins from the plan of the first."""
    # And what a run may need in its middle: boundaries remembered from elsewhere, and what was seen of them alone.
    for strategy in ("stop_guarantee", "bounce"):
        settings = Settings().with_values({"planner.strategy": strategy})
        planner = planner_for(strategy)
        plan, memory = planner.plan(None, local_map, state, goal, settings)
        follow(ControllerMemory(), plan, local_map, state, plan.stamp, settings)
        later = replace(state, stamp=state.stamp + 0.05)
        _, memory = planner.plan(memory, replace(local_map, stamp=later.stamp), later, goal, settings)
    elsewhere = replace(local_map, position=local_map.position + 0.5 * FIRST_SIDE)
    remember(memory.remembered, elsewhere, settings.robot, settings.remembered)
    nowhere = replace(memory.paths, waypoint=np.full_like(memory.paths.waypoint, -1))
    way_to_goal(memory.remembered, nowhere, state.position, settings)
    gap_on_the_way(memory.paths, memory.remembered.field, state.position)


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # at once and without a traceback; files are there whole or not at all
    warm_up()
