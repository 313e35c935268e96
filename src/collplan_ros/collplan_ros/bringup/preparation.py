"""Checks of a run before any node starts."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.parameters.file import read_parameters, write_parameters
from collplan_core.parameters.spec import ParameterError
from collplan_core.planners import first_memory
from collplan_core.worlds import UNKNOWN, World, WorldError, check_route, load_world
from collplan_ros.bringup.failures import StartError
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.processes import find_executable
from collplan_ros.bringup.robots import FIRST_SPEED, LIDAR, LOCKSTEP, NODES, SIM, VIEWER, RobotKind, robot_kind
from collplan_ros.bringup.words import in_words
from collplan_ros.view.listening import listening_socket

CHECK_SPEED = 3.0
"""Simulated seconds a second in a check of a simulated robot in lockstep."""


@dataclass(frozen=True, eq=False)
class Preparation:
    """A run that can be started.

    Attributes:
        robot: kind of the robot.
        network: discovery range, local or subnet.
        settings: parameters of all nodes.
        world: the world, as far as it is known.
        goal: (2,) [m].
        programs: path of each node's executable, by node name.
        namespace: of all nodes, with its leading slash.
        speed: how fast a robot that is not simulated drives, and what says so, in words; empty for others.
    """

    robot: RobotKind
    network: str
    settings: Settings
    world: World
    goal: np.ndarray
    programs: dict[str, str]
    namespace: str = "/"
    speed: str = ""

    @property
    def ends(self) -> list[np.ndarray]:
        """Goal and start (2,) [m], where a simulated robot may be driven to and fro."""
        return [end for end in (self.goal, self.world.start) if end is not None]


def prepare(options: Options) -> Preparation:
    """Checks the options of a run and resolves robot, parameters, world, goal and executables.

    Raises:
        StartError: an unknown robot, world, strategy or parameter, a value that does not fit, a goal that cannot be
            reached, a program that is not installed, or something that a robot which is not simulated needs.
    """
    robot = robot_kind(options.robot)
    _refuse_unsaid(options, robot)
    if options.again and not robot.simulated:
        raise StartError(f"--again: got --robot {options.robot}, expected a simulated one: it sets out again by itself")
    try:
        given = read_parameters(options.params) if options.params else {}
        settings, speed = _slow(_settings(options, robot, given), options, robot, given)
        world = load_world(settings.simulator.world)
        goal = _checked_goal(options, world, settings, robot)
        if options.view:
            listening_socket(settings.view.port).close()
    except (ParameterError, WorldError, OSError) as error:
        raise StartError(str(error)) from None
    onlookers = (VIEWER,) if options.view else ()
    nodes = [name for name in NODES if name != LIDAR or options.scan == SIM]
    found = {name: find_executable(name) for name in (*robot.nodes, *nodes, *onlookers)}
    network = options.network or robot.network or "local"
    return Preparation(robot, network, settings, world, goal, found, options.namespace, speed)


def write_used_parameters(path: Path, settings: Settings) -> None:
    """Writes every parameter of a run as a ROS parameter file for all nodes.

    Raises:
        StartError: it cannot be written.
    """
    try:
        write_parameters(settings, path)
    except OSError as error:
        raise StartError(f"{path}: cannot be written: {error.strerror or error}") from None


def _refuse_unsaid(options: Options, robot: RobotKind) -> None:
    """Refuses to guess where a robot that is not simulated is, where it goes, and who may command it."""
    needed: dict[str, object] = {"--network": options.network}
    if not options.check:
        world = {"--world": options.world} if options.scan == SIM else {}
        needed = {**world, "--goal": options.goal, **needed}
    missing = [option for option, value in needed.items() if value is None]
    if missing and not robot.simulated:
        raise StartError(
            f"--robot {options.robot} is not simulated, so {in_words(list(needed))} must be said; "
            f"missing: {in_words(missing)}"
        )


def _settings(options: Options, robot: RobotKind, given: Mapping[str, object]) -> Settings:
    values = {**robot.unless_given, **given, **robot.values, **options.values()}
    if options.check and values.get(LOCKSTEP):
        # its motions are the same, and nobody watches
        values = {"simulator.speed_factor": CHECK_SPEED, **values}
    if not robot.simulated and options.world is None and not options.check:
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


def _slow(settings: Settings, options: Options, robot: RobotKind, given: Mapping[str, object]) -> tuple[Settings, str]:
    """Has a robot that is not simulated drive no faster than FIRST_SPEED, unless it is said on the command line.

    Nobody means it by a parameter file: those that bringup writes hold every parameter, also of simulated runs.
    """
    if robot.simulated:
        return settings, ""
    said = settings.robot.max_speed
    if options.max_speed is not None:
        return settings, f"drives at {said:g} m/s at most: --max-speed"
    if "robot.max_speed" not in given:
        said, source = FIRST_SPEED, "no --max-speed was given"
    elif said > FIRST_SPEED:
        source = f"no --max-speed was given, and robot.max_speed {said:g} of {options.params} alone makes it no faster"
    else:
        source = f"robot.max_speed of {options.params}"
    slow = min(said, FIRST_SPEED)
    return settings.with_values({"robot.max_speed": slow}), f"drives at {slow:g} m/s at most: {source}"


def _checked_goal(options: Options, world: World, settings: Settings, robot: RobotKind) -> np.ndarray:
    goal = world.goal if options.goal is None else np.array(options.goal, dtype=float)
    if goal is None and options.check:
        goal = world.start if world.start is not None else np.zeros(2)  # nothing drives there
    if goal is None:
        raise WorldError(f"world {world.called}: goal: missing, expected goal: [x, y] in its file or --goal X Y")
    if world.start is None:
        if not robot.simulated:  # its true start is measured, not given by the world
            return goal
        raise WorldError(f"world {world.called}: has no start, expected one [x, y] [m] in it")
    check_route(world, world.start, goal, settings.robot.radius)
    return goal
