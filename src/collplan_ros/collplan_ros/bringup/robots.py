"""Several robots in one simulated world: what each of them is asked for."""

from dataclasses import replace

import numpy as np

from collplan_core.parameters import Simulation
from collplan_core.worlds import WorldError, check_route
from collplan_ros.bringup.failures import StartError
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import Preparation, prepare

APART = 3.0
"""Least distance of start and goal, in radii: noise moves the starts."""


def prepare_robots(options: Options) -> list[tuple[Options, Preparation]]:
    """Options and preparation of each robot: the first as if alone, the second from the first one's goal to its start.

    Each has a namespace, seeds and a folder of its own; only the first has a page.

    Raises:
        StartError: as `prepare`; another number of robots, or something that several cannot have.
    """
    if options.robots != 2:
        raise StartError(f"--robots: got {options.robots}, expected 1 or 2: start and goal of a world are two places")
    if options.robot != "sim" or options.processes or options.check:
        other = "--check" if options.check else "--processes" if options.processes else f"--robot {options.robot}"
        raise StartError(f"--robots: got {other}, expected simulated robots that drive in one process")
    if options.namespace is not None:
        raise StartError(f"--robots: got --namespace {options.namespace}, expected none: they are /robot1 and /robot2")
    if options.keep is not None:
        raise StartError(f"--keep: got {options.keep}, expected none with --robots: each learns a drive of its own")
    chosen = [
        replace(options, namespace=f"/robot{k}", out=options.out / f"robot{k}", view=options.view and k == 1)
        for k in (1, 2)
    ]
    first, second = map(prepare, chosen)
    world, goal, settings = first.world, first.goal, first.settings
    engine, only = settings.simulator.engine, Simulation().engine
    if engine != only:
        raise StartError(f"simulator.engine: got {engine}, expected {only} with --robots")
    if (settings.robot, settings.simulator) != (second.settings.robot, second.settings.simulator):
        raise StartError("--params: groups robot and simulator differ between the robots, expected the same for both")
    start = world.start
    assert start is not None, "checked by prepare"
    try:
        if world.movers:
            raise WorldError(f"world {world.called}: movers: got {len(world.movers)}, expected none with --robots")
        if (gap := float(np.hypot(*(goal - start)))) < APART * settings.robot.radius:
            raise WorldError(f"--robots: start and goal are {gap:.2f} m apart, expected {APART:g} radii of the robot")
        check_route(world, goal, start, settings.robot.radius, settings.planner.goal_tolerance)
    except WorldError as error:
        raise StartError(str(error)) from None
    seeds = {"simulator.seed": settings.simulator.seed + 1, "lidar.seed": settings.lidar.seed + 1}
    back = replace(world, start=goal, goal=start)
    second = replace(second, settings=second.settings.with_values(seeds), world=back, goal=start)
    return list(zip(chosen, (first, second), strict=True))
