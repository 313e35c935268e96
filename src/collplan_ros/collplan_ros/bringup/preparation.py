"""What is chosen, checked before any node starts: robot, parameters, world, goal, programs, and the LIDAR's place."""

import math
import os
import shutil
import sys
import time
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

from collplan_core.calibration.frame_chain import LidarMount, Link, mount_in
from collplan_core.parameters import Settings
from collplan_core.parameters.file import follows_clock, read_parameters
from collplan_core.parameters.spec import ParameterError
from collplan_core.planners import first_memory
from collplan_core.worlds import UNKNOWN, World, WorldError, check_route, load_world
from collplan_ros.bringup.ending import StartError
from collplan_ros.bringup.options import FIRST_SPEED, LIDAR, NODES, SIM, SPEED_FACTOR, VIEWER, Options, RobotKind
from collplan_ros.bringup.progress import in_words
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.messages.qos import LATCHED_TRANSFORMS, SENSOR_DATA
from collplan_ros.node_kit.node_names import full_name
from collplan_ros.node_kit.reachability import environment_set, graph_environment, why_no_graph
from collplan_ros.nodes.odometry_body import take_links
from collplan_ros.view.server import listening_socket

REMAPPED = ["-r", "/clock:=clock"]
"""Keeps a simulation's clock in its own namespace: ROS has one for all robots of a domain, /clock."""
MOUNT = {"scan.offset_x", "scan.offset_y", "scan.offset_yaw", "scan.mirrored"}
"""Parameters of the LIDAR's place on the robot."""
SERIAL_ENDS = {"firmware_emulator": "emulator.link", "driver_node": "driver.port"}
"""Parameters that name the pseudo-terminal in the place of a serial device, by node."""


@dataclass(frozen=True, eq=False)
class Preparation:
    """A run that can be started."""

    options: Options
    settings: Settings  # of all nodes
    world: World  # as far as known
    goal: np.ndarray  # (2,) [m]
    programs: dict[str, str]  # path of each node's executable, by node name
    speed: str = ""  # top speed of a robot that is not simulated, and its source, in words; empty for others
    lidar: str = (
        ""  # where a real LIDAR is on the robot, and how that is known, in words; empty where parameters say it
    )
    lidar_unsaid: bool = False  # whether the LIDAR is a real one whose place on the robot no parameter gives
    follows_clock: bool = False  # whether time is that of another simulator, on /clock

    @property
    def robot(self) -> RobotKind:
        """Kind of the robot."""
        return self.options.kind

    @property
    def namespace(self) -> str:
        """Namespace of all nodes, with its leading slash."""
        return self.options.graph

    @property
    def network(self) -> str:
        """Discovery range, local or subnet."""
        return self.options.network or "local"

    @property
    def environment(self) -> dict[str, str]:
        """Environment variables by which its nodes meet."""
        alone = self.robot.simulated and self.network == "local"
        return graph_environment(self.network, os.environ, alone)

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
        words = [] if self.follows_clock else REMAPPED
        return [*words, *(word for topic in outside for word in ("-r", f"{topic}:=/{topic}"))]

    def full_name(self, node: str) -> str:
        """Full name of a node of this graph."""
        return full_name(self.namespace, node)

    def arguments(self, name: str, folder: RunFolder) -> list[str]:
        """The arguments of a node, whose parameters are in a run folder."""
        ours = ["--params-file", str(folder.parameters), "-r", f"__ns:={self.namespace}", *self.remapped]
        link = name in SERIAL_ENDS and SERIAL_ENDS.keys() <= set(self.robot.nodes)
        serial = ["-p", f"{SERIAL_ENDS[name]}:={folder.serial}"] if link else []
        return ["--ros-args", *ours, *self.simulated_time, *serial]


def prepare(options: Options) -> Preparation:
    """Resolves parameters, world, goal and programs of a run; StartError where it cannot be driven as asked for."""
    robot, chosen = options.kind, options.values()
    try:
        given = read_parameters(options.params, options.graph) if options.params else {}
        follows = options.params is not None and follows_clock(options.params, options.graph)
        _refuse_unsaid(options)
        settings, speed = _slow(_settings(options, given, chosen), options, given)
        world = load_world(settings.simulator.world)
        goal = _checked_goal(options, world, settings)
        nodes = [name for name in NODES if name != LIDAR or options.scan == SIM]
        found = {name: find_executable(name) for name in (*robot.nodes, *nodes, *[VIEWER] * options.view)}
        if options.view:
            listening_socket(settings.view.port).close()
    except (ParameterError, WorldError, OSError) as error:
        raise StartError(str(error)) from None
    if follows and robot.simulated and not settings.simulator.publishes_clock:
        raise StartError(
            f"use_sim_time: got true in {options.params}, expected false: this simulator runs in real time"
        )
    unsaid = LIDAR not in found and not MOUNT & {*given, *chosen}
    prepared = Preparation(
        options, settings, world, goal, found, speed, lidar_unsaid=unsaid, follows_clock=follows and not robot.simulated
    )
    if why := why_no_graph({**os.environ, **prepared.environment}, prepared.network == "local"):
        raise StartError(why)
    return prepared


def find_executable(name: str) -> str:
    """Path of a node's executable, or StartError: beside this Python, in the sourced ROS workspaces, or on the PATH."""
    folders = [Path(sys.executable).parent]
    for prefix in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        folders += sorted(Path(prefix, "lib").glob("*/"))
    found = shutil.which(name, path=os.pathsep.join([*map(str, folders), os.environ.get("PATH", os.defpath)]))
    if found is None:
        places = f"beside {sys.executable}, in AMENT_PREFIX_PATH or on PATH"
        raise StartError(f"{name}: no such program {places}; is its package installed?")
    return found


def _refuse_unsaid(options: Options) -> None:
    """Requires world, goal and network on the command line for a robot that is not simulated."""
    if options.kind.simulated:
        return
    if options.again:
        raise StartError(f"--again: got --robot {options.robot}, expected a simulated one: it starts again by itself")
    world = {"--world": options.world} if options.scan == SIM else {}
    needed: dict[str, object] = {**world, "--goal": options.goal, "--network": options.network}
    missing = [option for option, value in needed.items() if value is None]
    if missing:
        raise StartError(
            f"--robot {options.robot} is not simulated, so {in_words(list(needed))} must be given; "
            f"missing: {in_words(missing)}"
        )


def _settings(options: Options, given: Mapping[str, object], chosen: Mapping[str, object]) -> Settings:
    robot = options.kind
    # a base of others' making rolls on past a goal that it is only to pass
    values = {"planner.stop_at_goal": robot.stops_at_goal, **given, **robot.values, **chosen}
    factor = values.get(SPEED_FACTOR, 1.0)
    if options.in_one_process and factor not in (0.0, 1.0):
        raise ParameterError(f"{SPEED_FACTOR}: got {factor}, expected 1, or --processes: in one process time waits")
    values[SPEED_FACTOR] = 0.0 if options.in_one_process else factor or 1.0  # the 0 of a file is of one process, too
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


def _slow(settings: Settings, options: Options, given: Mapping[str, object]) -> tuple[Settings, str]:
    """Limits a real robot to FIRST_SPEED unless the command line sets one: parameter files hold simulated runs' too."""
    if options.kind.simulated:
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


def _checked_goal(options: Options, world: World, settings: Settings) -> np.ndarray:
    goal = world.goal if options.goal is None else np.array(options.goal, dtype=float)
    if goal is None:
        raise WorldError(f"world {world.called}: goal: missing, expected goal: [x, y] in its file or --goal X Y")
    if world.start is not None:
        check_route(world, world.start, goal, settings.robot.radius, settings.planner.goal_tolerance)
    elif options.kind.simulated:  # the start of any other is measured, not given by the world
        raise WorldError(f"world {world.called}: has no start, expected one [x, y] [m] in it")
    return goal


PATIENCE, LOOK_PERIOD = 3.0, 0.05
"""Longest wait for scans and transforms, and period at which what came is looked at [s]."""


def with_lidar_place(preparation: Preparation) -> Preparation:
    """The preparation with the LIDAR where /tf_static says, unless parameters say it; StartError for a tilted one."""
    if not preparation.lidar_unsaid:
        return preparation
    base = preparation.settings.frames.base
    try:
        frame, mount = _listened(preparation)
    except ValueError as error:
        raise StartError(f"/tf_static: {error}") from None
    if mount is None:
        said = (
            f"LIDAR: taken to be at the robot's centre, facing forward. /tf_static has no transform from {base} to "
            f"{frame or 'the frame of the scans, none of which came'}: scan.offset_x, _y and _yaw can say it"
        )
        return replace(preparation, lidar=said)
    found = {f"scan.offset_{key}": getattr(mount, key) for key in ("x", "y", "yaw")}
    values = {**found, "scan.mirrored": mount.mirrored, "scan.frame": "" if frame == base else frame}
    place = f"{mount.x:.3f} m forward, {mount.y:.3f} m left, turned by {math.degrees(mount.yaw):.1f} degrees"
    said = f"LIDAR: {frame} is {place}{', upside down' * mount.mirrored}: /tf_static"
    return replace(preparation, settings=preparation.settings.with_values(values), lidar=said)


def _listened(preparation: Preparation) -> tuple[str, LidarMount | None]:
    """Frame of the scans, "" where none came, and its place, None where /tf_static does not join it to the robot."""
    try:
        from tf2_msgs.msg import TFMessage
    except ImportError:
        return preparation.settings.scan.frame, None
    links: dict[str, Link] = {}
    frames, base = [preparation.settings.scan.frame], preparation.settings.frames.base

    def take_scan(message: LaserScan) -> None:
        frames[0] = frames[0] or str(message.header.frame_id)

    with ExitStack() as stack:
        stack.enter_context(environment_set(preparation.environment))
        context = Context()
        stack.callback(context.try_shutdown)
        arguments = ["--ros-args", *preparation.remapped]
        try:
            context.init(args=[])
            node = Node("lidar_place", context=context, namespace=preparation.namespace, cli_args=arguments)
        except RuntimeError:  # ROS does not start: bringup's own node says why
            return frames[0], None
        stack.callback(node.destroy_node)
        node.create_subscription(TFMessage, "/tf_static", partial(take_links, links), LATCHED_TRANSFORMS)
        node.create_subscription(LaserScan, "scan", take_scan, SENSOR_DATA)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        stack.callback(executor.shutdown)
        end = time.monotonic() + PATIENCE
        while (mount := mount_in(links, base, frames[0])) is None and time.monotonic() < end:
            executor.spin_once(LOOK_PERIOD)
    return frames[0], mount
