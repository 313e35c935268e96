"""Checks of a run before any node starts."""

import os
import shutil
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.parameters.file import follows_clock, read_parameters
from collplan_core.parameters.spec import ParameterError
from collplan_core.planners import first_memory
from collplan_core.worlds import UNKNOWN, World, WorldError, check_route, load_world
from collplan_ros.bringup.failures import StartError
from collplan_ros.bringup.network import graph_environment
from collplan_ros.bringup.options import (
    FIRST_SPEED,
    LIDAR,
    NODES,
    SIM,
    SPEED_FACTOR,
    VIEWER,
    Options,
    RobotKind,
    robot_kind,
)
from collplan_ros.bringup.progress import in_words
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.node_kit.node_names import full_name
from collplan_ros.node_kit.reachability import why_no_graph
from collplan_ros.view.server import listening_socket

REMAPPED = ["-r", "/clock:=clock"]
"""Keeps a simulation's clock in its own namespace: ROS has one for all robots of a domain, /clock."""
MOUNT = {"scan.offset_x", "scan.offset_y", "scan.offset_yaw", "scan.mirrored"}
"""Parameters of the LIDAR's place on the robot."""
SERIAL_ENDS = {"firmware_emulator": "emulator.link", "driver_node": "driver.port"}
"""Parameters that name the pseudo-terminal in the place of a serial device, by node."""


@dataclass(frozen=True, eq=False)
class Preparation:
    """A run that can be started.

    Attributes:
        robot: kind of the robot.
        network: discovery range, local or subnet.
        settings: parameters of all nodes.
        world: the world, as far as known.
        goal: (2,) [m].
        programs: path of each node's executable, by node name.
        namespace: namespace of all nodes, with its leading slash.
        asked: command-line options that no parameter file holds, without the goal.
        speed: top speed of a robot that is not simulated, and its source, in words; empty for others.
        in_one_process: whether the robot and its nodes run in bringup's process, where simulated time waits for them.
        in_real_time: whether simulated time is at most as fast as real time there.
        lidar_unsaid: whether the LIDAR is a real one whose place on the robot no parameter gives.
        follows_clock: whether time is that of another simulator, on /clock.
    """

    robot: RobotKind
    network: str
    settings: Settings
    world: World
    goal: np.ndarray
    programs: dict[str, str]
    asked: Sequence[str] = ()
    namespace: str = "/"
    speed: str = ""
    in_one_process: bool = False
    in_real_time: bool = True
    lidar_unsaid: bool = False
    follows_clock: bool = False

    @property
    def ends(self) -> list[np.ndarray]:
        """Goal and start (2,) [m], where a simulated robot may be driven to and fro."""
        return [end for end in (self.goal, self.world.start) if end is not None]

    @property
    def where(self) -> str:
        """Domain, extent and namespace of the graph, in words."""
        within = "" if self.namespace == "/" else f", namespace {self.namespace}"
        return f"domain {os.environ.get('ROS_DOMAIN_ID') or '0'}, network {self.network}{within}"

    @property
    def simulated_time(self) -> list[str]:
        """Arguments by which a node follows the simulation's clock, where there is one."""
        return ["-p", "use_sim_time:=true"] if self.settings.simulator.publishes_clock or self.follows_clock else []

    @property
    def remapped(self) -> list[str]:
        """Arguments by which a node finds the topics that are not in the graph's namespace."""
        outside = self.robot.outside if self.namespace == self.robot.namespace else ()
        return [
            *REMAPPED * (not self.follows_clock),
            *(word for topic in outside for word in ("-r", f"{topic}:=/{topic}")),
        ]

    def full_name(self, node: str) -> str:
        """Full name of a node of this graph."""
        return full_name(self.namespace, node)

    def command(self, name: str, folder: RunFolder) -> list[str]:
        """The command line of a node, whose parameters are in a run folder."""
        return [self.programs[name], *self.arguments(name, folder)]

    def arguments(self, name: str, folder: RunFolder) -> list[str]:
        """The arguments of a node, whose parameters are in a run folder."""
        ours = ["--params-file", str(folder.parameters), "-r", f"__ns:={self.namespace}", *self.remapped]
        link = self.robot.emulated and name in SERIAL_ENDS
        serial = ["-p", f"{SERIAL_ENDS[name]}:={folder.serial}"] if link else []
        return ["--ros-args", *ours, *self.simulated_time, *serial]


def prepare(options: Options) -> Preparation:
    """Checks the options of a run and resolves robot, parameters, world, goal and executables.

    Raises:
        StartError: nodes cannot meet here, an unknown robot, world, strategy or parameter, a value that does not fit,
            a goal that cannot be reached, a program that is not installed, or something that a robot which is not
            simulated needs.
    """
    robot = robot_kind(options.robot)
    network = options.network or robot.network or "local"
    environment = {**os.environ, **graph_environment(network, os.environ, robot.simulated and network == "local")}
    if why := why_no_graph(environment, network == "local"):
        raise StartError(why)
    asked, chosen = options.asked(robot.simulated), options.values()
    try:
        given = read_parameters(options.params, options.graph) if options.params else {}
        follows = options.params is not None and follows_clock(options.params, options.graph)
        _refuse_unsaid(options, robot)
        settings, speed = _slow(_settings(options, robot, given, chosen), options, robot, given)
        world = load_world(settings.simulator.world)
        goal = _checked_goal(options, world, settings, robot)
        nodes = [name for name in NODES if name != LIDAR or options.scan == SIM]
        found = {name: find_executable(name) for name in (*robot.nodes, *nodes, *[VIEWER] * options.view)}
        if options.view:
            listening_socket(settings.view.port).close()
    except (ParameterError, WorldError, OSError) as error:
        raise StartError(str(error)) from None
    steps = _steps(options, robot), options.real_time or options.view
    unsaid = LIDAR not in found and not MOUNT & {*given, *chosen}
    if follows and robot.simulated and not settings.simulator.publishes_clock:
        raise StartError(
            f"use_sim_time: got true in {options.params}, expected false: this simulator runs in real time"
        )
    about = asked, options.graph, speed, *steps, unsaid, follows and not robot.simulated
    return Preparation(robot, network, settings, world, goal, found, *about)


def find_executable(name: str) -> str:
    """Path of a node's executable: beside this Python, in the sourced ROS workspaces, or on the PATH.

    Raises:
        StartError: it is in none of these.
    """
    folders = [Path(sys.executable).parent]
    for prefix in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        folders += sorted(Path(prefix, "lib").glob("*/"))
    found = shutil.which(name, path=os.pathsep.join([*map(str, folders), os.environ.get("PATH", os.defpath)]))
    if found is None:
        places = f"beside {sys.executable}, in AMENT_PREFIX_PATH or on PATH"
        raise StartError(f"{name}: no such program {places}; is its package installed?")
    return found


def _refuse_unsaid(options: Options, robot: RobotKind) -> None:
    """Requires world, goal and network on the command line for a robot that is not simulated."""
    if robot.simulated:
        return
    if options.again:
        raise StartError(f"--again: got --robot {options.robot}, expected a simulated one: it starts again by itself")
    needed: dict[str, object] = {"--world": options.world, "--goal": options.goal, "--network": options.network}
    if options.scan != SIM:
        del needed["--world"]
    missing = [option for option, value in needed.items() if value is None]
    if missing:
        raise StartError(
            f"--robot {options.robot} is not simulated, so {in_words(list(needed))} must be given; "
            f"missing: {in_words(missing)}"
        )


def _settings(
    options: Options, robot: RobotKind, given: Mapping[str, object], chosen: Mapping[str, object]
) -> Settings:
    # a base of others' making rolls on past a goal that it is only to pass
    values = {"planner.stop_at_goal": robot.stops_at_goal, **given, **robot.values, **chosen}
    values[SPEED_FACTOR] = _speed_factor(values.get(SPEED_FACTOR, 1.0), _steps(options, robot))
    if not robot.simulated and options.world is None:
        # a world of the parameter file was another run's
        values |= {"lidar.world": UNKNOWN, "simulator.world": UNKNOWN}
    for key in ("lidar.world", "simulator.world"):
        # absolute, so that the parameter file written can be used from any folder
        if key in values and Path(str(values[key])).is_file():
            values[key] = str(Path(str(values[key])).resolve())
    settings = Settings().with_values(values)
    first_memory(settings, None)
    if robot.simulated and settings.simulator.noise * settings.simulator.mocap_noise == 0.0:
        # without noise the poses of a robot at rest repeat exactly
        settings = settings.with_values({"mocap.accept_frozen": values.get("mocap.accept_frozen", True)})
    return settings


def _steps(options: Options, robot: RobotKind) -> bool:
    """Returns whether the nodes run in bringup's process."""
    return robot.in_one_process and not options.processes


def _speed_factor(given: object, steps: bool) -> object:
    """Returns simulator.speed_factor: 0 in one process; else that of the file, whose 0 is of a run in one process."""
    if not steps:
        return given or 1.0
    if given not in (0.0, 1.0):
        raise ParameterError(f"{SPEED_FACTOR}: got {given}, expected 1, or --processes: in one process time waits")
    return 0.0


def _slow(settings: Settings, options: Options, robot: RobotKind, given: Mapping[str, object]) -> tuple[Settings, str]:
    """Limits a robot that is not simulated to FIRST_SPEED, unless the command line sets a speed.

    A parameter file does not count: those that bringup writes hold every parameter, also of simulated runs.
    """
    if robot.simulated:
        return settings, ""
    said = settings.robot.max_speed
    if options.max_speed is not None:
        return settings, f"drives at {settings.robot.fastest:g} m/s at most: --max-speed"
    if "robot.max_speed" not in given:
        said, source = FIRST_SPEED, "no --max-speed was given"
    elif said > FIRST_SPEED:
        source = f"no --max-speed was given, and robot.max_speed {said:g} of {options.params} alone makes it no faster"
    else:
        source = f"robot.max_speed of {options.params}"
    slowed = settings.with_values({"robot.max_speed": min(said, FIRST_SPEED)})
    return slowed, f"drives at {slowed.robot.fastest:g} m/s at most: {source}"


def _checked_goal(options: Options, world: World, settings: Settings, robot: RobotKind) -> np.ndarray:
    goal = world.goal if options.goal is None else np.array(options.goal, dtype=float)
    if goal is None:
        raise WorldError(f"world {world.called}: goal: missing, expected goal: [x, y] in its file or --goal X Y")
    if world.start is None:
        if not robot.simulated:  # its true start is measured, not given by the world
            return goal
        raise WorldError(f"world {world.called}: has no start, expected one [x, y] [m] in it")
    check_route(world, world.start, goal, settings.robot.radius, settings.planner.goal_tolerance)
    return goal
