"""What is chosen: the robots that bringup can start, and its command line."""

# ruff: noqa: RUF009 (a field of a dataclass is made by a call)
import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from collplan_core.command_line import as_called, parser_of
from collplan_core.parameters import Settings, all_specs
from collplan_core.planners import PLANNERS
from collplan_ros.bringup.ending import StartError
from collplan_ros.node_kit.node_names import namespace_from
from collplan_ros.node_kit.reachability import RANGES

SERIAL, BASE, SIMULATOR = "serial", "base", "simulator_node"


@dataclass(frozen=True)
class RobotKind:
    """A kind of robot; its nodes are started by executable name, so that this package does not depend on theirs."""

    nodes: tuple[str, ...]  # first the one that receives commands, then the devices behind it; named like executables
    simulated: bool  # whether its motion is simulated; where it is not, bringup needs to be told more
    values: Mapping[str, object] = field(default_factory=dict)  # parameters set for this robot, by key
    in_one_process: bool = False  # whether its nodes can run in bringup's process, where simulated time waits for them
    namespace: str = "/"  # default namespace of its graph
    outside: tuple[str, ...] = ()  # topics that its own nodes publish without a namespace, where the default is used
    stops_at_goal: bool = False  # planner.stop_at_goal, unless it is given


SPEED_FACTOR = "simulator.speed_factor"
EMULATOR = RobotKind(("driver_node", "firmware_emulator"), True, {SPEED_FACTOR: 1.0})  # a serial line has real time
ROBOTS = {
    "sim": RobotKind((SIMULATOR,), True, in_one_process=True),
    "emulator": EMULATOR,
    "emulator:c": replace(EMULATOR, values={**EMULATOR.values, "emulator.firmware": "c"}),
}
ANY_BASE = RobotKind(("base_node",), False, namespace="/collplan", outside=("scan",), stops_at_goal=True)
"""Its own cmd_vel is another topic than the one of the graph, which is therefore in a namespace."""
EXPECTED = f"{', '.join(ROBOTS)}, {SERIAL}:PATH, {SERIAL}:PATH@BAUD or {BASE}:TOPIC"
FIRST_SPEED = 0.3  # highest robot.max_speed of a robot that is not simulated, unless --max-speed is given [m/s]
COMMANDER, PLANNER = "controller_node", "planner_node"
"""The only node that commands the robot, and the one that takes goals."""
LIDAR = "lidar_node"  # the node of SIM alone
NODES = ("mocap_node", LIDAR, PLANNER, COMMANDER)  # beside every robot; each executable is named like its node
SIM = "sim"  # source of the scans that the robot drives by: lidar_node; the other is a LIDAR whose driver runs already
VIEWER = "view_node"  # the node of the live page, where it is asked for: a run goes on without it


def robot_kind(spec: str) -> RobotKind:
    """The robot kind for sim, emulator, serial:PATH, serial:PATH@BAUD or base:TOPIC; StartError for another text."""
    if spec in ROBOTS:
        return ROBOTS[spec]
    name, _, device = spec.partition(":")
    if name == BASE and device:
        return replace(ANY_BASE, values={"base.topic": device})
    path, at, rate = device.rpartition("@") if "@" in device else (device, "", "")
    if name != SERIAL or not path or (at and not rate.isdecimal()):
        raise StartError(f"--robot: got {spec!r}, expected one of {EXPECTED}")
    return RobotKind(("driver_node",), False, {"driver.port": path, **({"driver.baud": int(rate)} if rate else {})})


DEFAULTS = Settings()
ENGINES = " | ".join(all_specs()["simulator.engine"].choices)


def _option(flag: str, about: str, default: Any = None, **given: Any) -> Any:
    """Returns an option for argparse; one that is True or False by default sets the opposite."""
    if isinstance(default, bool):
        given["action"] = "store_false" if default else "store_true"
    return field(default=default, metadata={"flag": flag, "help": about, **given})


@dataclass(frozen=True)
class Options:
    """Options of one run, as `bringup --help` explains them.

    None leaves a value to the parameter file, or else to the parameter's default.
    """

    robot: str = _option("--robot", f"{EXPECTED} (default sim, the simulated one)", "sim")
    world: str | None = _option("--world", f"world: NAME, FILE or FAMILY:SEED (default {DEFAULTS.simulator.world})")
    strategy: str | None = _option("--strategy", f"{' | '.join(PLANNERS)} (default {DEFAULTS.planner.strategy})")
    goal: tuple[float, float] | None = _option(
        "--goal", "goal position [m] (default the world's own goal)", nargs="+", metavar=("X", "Y")
    )
    engine: str | None = _option("--engine", f"simulator.engine: {ENGINES} (default {DEFAULTS.simulator.engine})")
    seed: int | None = _option("--seed", f"seed of the simulated noise (default {DEFAULTS.simulator.seed})", type=int)
    params: Path | None = _option("--params", "ROS parameter file; the options above and below outrank it", type=Path)
    out: Path = _option("--out", "where run folders go (default runs)", Path("runs"), type=Path)
    timeout: float | None = _option("--timeout", f"longest run [s] (default {DEFAULTS.trial.timeout:g})", type=float)
    network: str | None = _option(
        "--network",
        "discovery range of the nodes: this machine or the subnet (default local; required for serial)",
        choices=sorted(RANGES),
    )
    max_speed: float | None = _option(
        "--max-speed",
        f"robot.max_speed (default {DEFAULTS.robot.max_speed:g} m/s; for serial {FIRST_SPEED:g} or less)",
        type=float,
    )
    namespace: str | None = _option(
        "--namespace",
        "namespace of all nodes and topics, as robot1: one for each robot of a domain (default none; base: collplan)",
    )
    pictures: bool = _option("--no-pictures", "leave out trajectory.png and run.html", True)
    scan: str = _option(
        "--scan",
        "source of scans: lidar_node, which casts rays in the world, or a real LIDAR (default sim)",
        SIM,
        choices=(SIM, "real"),
    )
    real_time: bool = _option("--real-time", "simulated time no faster than real time, as always with --view", False)
    processes: bool = _option("--processes", "a process for each simulated node, in real time, waiting for none", False)
    view: bool = _option("--view", "show the run in a browser, at the printed address (view.port)", False)
    journal: bool = _option("--no-journal", "do not record what replay needs (planner.journal: false)", True)
    again: bool = _option("--again", "drive to and fro until Ctrl-C; simulated robots only", False)

    @property
    def kind(self) -> RobotKind:
        """The kind of the robot; StartError where there is none of this name."""
        return robot_kind(self.robot)

    @property
    def graph(self) -> str:
        """Namespace of the graph, with its leading slash."""
        return self.namespace if self.namespace is not None else self.kind.namespace

    @property
    def in_one_process(self) -> bool:
        """Whether the robot and its nodes run in bringup's process, where simulated time waits for them."""
        return self.kind.in_one_process and not self.processes

    def values(self) -> dict[str, object]:
        """The parameters that these options set, by key."""
        chosen = {
            "lidar.world": self.world,
            "simulator.world": self.world,
            "planner.strategy": self.strategy,
            "simulator.engine": self.engine,
            "simulator.seed": self.seed,
            "lidar.seed": self.seed,
            "trial.timeout": self.timeout,
            "robot.max_speed": self.max_speed,
            "planner.journal": None if self.journal else False,
        }
        return {key: value for key, value in chosen.items() if value is not None}

    def repeated(self, parameters: Path, goal: np.ndarray) -> str:
        """Returns the command line that repeats a run with the file of its parameters, to a goal (2,) [m]."""
        # what no parameter file holds
        given = {
            "--robot": self.robot,
            "--network": self.network,
            "--namespace": None if self.graph == self.kind.namespace else self.graph,
            "--scan": None if self.scan == SIM else self.scan,
        }
        if not self.kind.simulated:  # it requires world and speed on the command line
            given |= {"--world": self.world, "--max-speed": None if self.max_speed is None else f"{self.max_speed:g}"}
        words = [word for option, value in given.items() if value is not None for word in (option, value)]
        # argparse takes -1e-05 for an option
        to = (np.format_float_positional(value, trim="0") for value in goal)
        words += [*["--processes"] * self.processes, "--params", str(parameters), "--goal", *to]
        return shlex.join([as_called("bringup"), *words])


DESCRIPTION = """\
Starts a robot and the nodes that plan and control it, gives it a goal, and watches until it is there.

The goal is reached: exit code 0. Time is up, stuck or given up: 1. A request that cannot be fulfilled, such as a
parameter that a node refuses: 2.
A node died, the graph did not come up, another node commands the robot, this machine is too slow for it, or the robot
is held or drives on after the goal: 3.
A file of the run cannot be written, as on a full disk: 4.
Stopped by a signal: 128 + its number; by Ctrl-C with --again: 0.

A robot that is not simulated needs --world, --goal and --network, and drives at 0.3 m/s at most unless --max-speed
is given: a parameter file can lower that limit, not raise it. With --scan real it needs no --world: its LIDAR shows
its surroundings.
"""
EPILOG = """\
examples:
  bringup                                           the corridor, simulated
  bringup --world random:7 --strategy low_risk      another arena, another strategy
  bringup --world my_arena.yaml --goal 2.0 0.4      your own world and goal
  bringup --world serpentine:2 --strategy bounce --view --again
      to watch in a browser, until Ctrl-C
  bringup --robot emulator                          over serial bytes, to an emulated firmware
  bringup --robot serial:/dev/ttyUSB0 --world floor.yaml --goal 1.0 0.5 --network subnet
      the real robot, slow, its LIDAR simulated in the world of a file
  bringup --robot serial:/dev/ttyUSB0 --scan real --goal 1.0 0.5 --network subnet --params lab.yaml
      the real robot and its own LIDAR, whose driver runs already
  bringup --robot base:/cmd_vel --scan real --goal 1.0 0.5 --network local --params base.yaml
      any robot that takes cmd_vel; the graph is in the namespace collplan
  bringup --params runs/latest/parameters.yaml --goal 2.0 0.4
      the last run's parameters, and a goal, which no file holds

Each run leaves a folder: run.html, which plays it in a browser, trajectory.png and .csv, impacts.csv, summary.json,
parameters.yaml, the output of each node in log/, and run.mcap, which holds every topic and is written during the run.
replay and beside make the results of a run whose bringup was killed.
ROS_DOMAIN_ID is used as it is set. A domain can hold several robots, each with its own --namespace.
"""


def _point(words: Sequence[str]) -> tuple[float, float]:
    try:
        x, y = (float(number) for number in " ".join(words).replace(",", " ").split())
    except ValueError:
        raise ValueError(f"--goal: got {' '.join(words)}, expected two numbers X Y [m]") from None
    return x, y


def parse(args: Sequence[str] | None = None) -> Options:
    """The options on a command line without the program's name; sys.argv's when None."""
    parser = parser_of("bringup", DESCRIPTION, EPILOG, "%(prog)s [options] (see --help)")
    for option in fields(Options):
        flag, *given = option.metadata.items()
        parser.add_argument(flag[1], dest=option.name, default=option.default, **dict(given))
    if "--check" in (sys.argv if args is None else args):
        parser.error("--check: no longer an option, inspect --live 60 takes its place, while you drive by hand")
    said = vars(parser.parse_args(args))
    try:
        for name, read in (("goal", _point), ("namespace", namespace_from)):
            said[name] = None if said[name] is None else read(said[name])
        robot_kind(said["robot"])
    except (StartError, ValueError) as error:
        parser.error(str(error))
    return Options(**said)
