"""Command line of bringup, and the robots that it can start."""

# ruff: noqa: RUF009 (a field of a dataclass is made by a call)
import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from typing import Any

from collplan_core.command_line import parser_of
from collplan_core.parameters import Settings, all_specs
from collplan_core.planners import PLANNERS
from collplan_ros.bringup.failures import StartError
from collplan_ros.bringup.network import RANGES
from collplan_ros.node_kit.node_names import namespace_from

SERIAL, BASE, SIMULATOR = "serial", "base", "simulator_node"


@dataclass(frozen=True)
class RobotKind:
    """A kind of robot; its nodes are started by executable name, so that this package does not depend on theirs.

    Attributes:
        nodes: its nodes, first the one that receives commands, then the devices behind it; each executable is named
            like its node.
        simulated: whether the motion of the robot is simulated.
        network: default discovery range, local or subnet; None where it is required on the command line.
        emulated: whether a pseudo-terminal replaces the serial device.
        values: parameters set for this robot, by key.
        in_one_process: whether its nodes can run in bringup's process, where simulated time waits for them.
        namespace: default namespace of its graph.
        outside: topics that its own nodes publish without a namespace, where the graph has that default.
        stops_at_goal: planner.stop_at_goal, unless it is given.
    """

    nodes: tuple[str, ...]
    simulated: bool
    network: str | None
    emulated: bool = False
    values: Mapping[str, object] = field(default_factory=dict)
    in_one_process: bool = False
    namespace: str = "/"
    outside: tuple[str, ...] = ()
    stops_at_goal: bool = False


SPEED_FACTOR = "simulator.speed_factor"
EMULATOR = RobotKind(
    nodes=("driver_node", "firmware_emulator"),
    simulated=True,
    network="local",
    emulated=True,
    values={SPEED_FACTOR: 1.0},  # a serial line has real time
)
ROBOTS = {
    "sim": RobotKind(nodes=(SIMULATOR,), simulated=True, network="local", in_one_process=True),
    "emulator": EMULATOR,
    "emulator:c": replace(EMULATOR, values={**EMULATOR.values, "emulator.firmware": "c"}),
}
ANY_BASE = RobotKind(
    nodes=("base_node",),
    simulated=False,
    network=None,
    namespace="/collplan",
    outside=("scan",),
    stops_at_goal=True,
)
"""Its own cmd_vel is another topic than the one of the graph, which is therefore in a namespace."""
EXPECTED = f"{', '.join(ROBOTS)}, {SERIAL}:PATH, {SERIAL}:PATH@BAUD or {BASE}:TOPIC"
FIRST_SPEED = 0.3
"""Highest robot.max_speed of a robot that is not simulated, unless --max-speed is given [m/s]."""
COMMANDER, PLANNER = "controller_node", "planner_node"
"""The only node that commands the robot, and the one that takes goals."""
LIDAR = "lidar_node"
"""The node of SIM alone."""
NODES = ("mocap_node", LIDAR, PLANNER, COMMANDER)
"""Nodes that run beside every robot; each executable is named like its node."""
SIM, REAL = "sim", "real"
"""Source of the scans that the robot drives by: lidar_node, or a LIDAR whose driver is started elsewhere."""
VIEWER = "view_node"
"""The node of the live page, where it is asked for: a run goes on without it."""


def robot_kind(spec: str) -> RobotKind:
    """The robot kind for sim, emulator, serial:PATH, serial:PATH@BAUD or base:TOPIC.

    Raises:
        StartError: another specification.
    """
    if spec in ROBOTS:
        return ROBOTS[spec]
    name, _, device = spec.partition(":")
    if name == BASE and device:
        return replace(ANY_BASE, values={"base.topic": device})
    path, at, rate = device.rpartition("@") if "@" in device else (device, "", "")
    if name != SERIAL or not path or (at and not rate.isdecimal()):
        raise StartError(f"robot {spec!r}: unknown, expected one of {EXPECTED}")
    values: dict[str, object] = {"driver.port": path}
    if rate:
        values["driver.baud"] = int(rate)
    return RobotKind(nodes=("driver_node",), simulated=False, network=None, values=values)


DEFAULTS = Settings()


def _checked(read: Callable[[str], object], text: str) -> str:
    """Returns the text if `read` accepts it; its errors become argparse's own."""
    try:
        read(text)
    except (StartError, ValueError) as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return text


def _option(flag: str, default: Any, about: str, **given: Any) -> Any:
    """Returns an option for argparse; one that is True or False by default sets the opposite."""
    if isinstance(default, bool):
        given["action"] = "store_false" if default else "store_true"
    return field(default=default, metadata={"flag": flag, "help": about, **given})


@dataclass(frozen=True)
class Options:
    """Options of one run, as `bringup --help` explains them.

    None leaves a value to the parameter file, or else to the parameter's default.
    """

    robot: str = _option(
        "--robot", "sim", f"{EXPECTED} (default sim, the simulated one)", type=partial(_checked, robot_kind)
    )
    world: str | None = _option(
        "--world", None, f"world: NAME, FILE or FAMILY:SEED (default {DEFAULTS.simulator.world})", metavar="W"
    )
    strategy: str | None = _option(
        "--strategy", None, f"{' | '.join(PLANNERS)} (default {DEFAULTS.planner.strategy})", metavar="NAME"
    )
    goal: tuple[float, float] | None = _option(
        "--goal", None, "goal position [m] (default the world's own goal)", nargs="+", metavar=("X", "Y")
    )
    engine: str | None = _option(
        "--engine",
        None,
        f"simulator.engine: {' | '.join(all_specs()['simulator.engine'].choices)} "
        f"(default {DEFAULTS.simulator.engine})",
        metavar="NAME",
    )
    seed: int | None = _option(
        "--seed", None, f"seed of the simulated noise (default {DEFAULTS.simulator.seed})", type=int, metavar="N"
    )
    params: Path | None = _option(
        "--params", None, "ROS parameter file; the options above and below outrank it", type=Path, metavar="FILE"
    )
    out: Path = _option("--out", Path("runs"), "where run folders go (default runs)", type=Path, metavar="DIR")
    timeout: float | None = _option(
        "--timeout", None, f"longest run [s] (default {DEFAULTS.trial.timeout:g})", type=float, metavar="S"
    )
    network: str | None = _option(
        "--network",
        None,
        "discovery range of the nodes: this machine or the subnet (default local; required for serial)",
        choices=sorted(RANGES),
    )
    max_speed: float | None = _option(
        "--max-speed",
        None,
        f"robot.max_speed (default {DEFAULTS.robot.max_speed:g} m/s; for serial {FIRST_SPEED:g} or less)",
        type=float,
        metavar="V",
    )
    namespace: str | None = _option(
        "--namespace",
        None,
        "namespace of all nodes and topics, as robot1: one for each robot of a domain (default none; base: collplan)",
        type=partial(_checked, namespace_from),
        metavar="NAME",
    )
    pictures: bool = _option("--no-pictures", True, "leave out trajectory.png and run.html")
    scan: str = _option(
        "--scan",
        SIM,
        "source of scans: lidar_node, which casts rays in the world, or a real LIDAR (default sim)",
        choices=(SIM, REAL),
    )
    real_time: bool = _option(
        "--real-time", False, "simulated time no faster than real time; with --view it is so anyway"
    )
    processes: bool = _option(
        "--processes", False, "a process for each node of the simulated robot, in real time that waits for none"
    )
    view: bool = _option("--view", False, "show the run in a browser, at the printed address (view.port)")
    journal: bool = _option("--no-journal", True, "do not record what replay needs (planner.journal: false)")
    again: bool = _option("--again", False, "drive to and fro until Ctrl-C; simulated robots only")

    @property
    def graph(self) -> str:
        """Namespace of the graph, with its leading slash."""
        return self.namespace if self.namespace is not None else robot_kind(self.robot).namespace

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

    def asked(self, simulated: bool) -> list[str]:
        """Returns the options that repeat the run, beside parameters and goal: those that no parameter file holds."""
        # a robot that is not simulated requires world and speed on the command line
        speed = None if self.max_speed is None else f"{self.max_speed:g}"
        said = {"--world": self.world, "--max-speed": speed} if not simulated else {}
        where = {
            "--network": self.network,
            "--namespace": None if self.graph == robot_kind(self.robot).namespace else self.graph,
            "--scan": None if self.scan == SIM else self.scan,
        }
        given = {"--robot": self.robot, **where, **said}
        words = [word for option, value in given.items() if value is not None for word in (option, value)]
        return [*words, *["--processes"] * self.processes]


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
replay and beside make the results of a run whose bringup was killed. The command line that repeats the run is printed
at its end, and is in summary.json.
ROS_DOMAIN_ID is used as it is set. A domain can hold several robots, each with its own --namespace.
"""


def _parser() -> argparse.ArgumentParser:
    parser = parser_of("bringup", DESCRIPTION, EPILOG, "%(prog)s [options] (see --help)")
    for option in fields(Options):
        flag, *given = option.metadata.items()
        parser.add_argument(flag[1], dest=option.name, default=option.default, **dict(given))
    return parser


def _point(words: Sequence[str]) -> tuple[float, float]:
    x, y = (float(number) for number in " ".join(words).replace(",", " ").split())
    return x, y


def parse(args: Sequence[str] | None = None) -> Options:
    """The options on a command line without the program's name; sys.argv's when None."""
    parser = _parser()
    if "--check" in (sys.argv if args is None else args):
        parser.error("--check: no longer an option, inspect --live 60 takes its place, while you drive by hand")
    given = vars(parser.parse_args(args))
    goal, namespace = given.pop("goal"), given["namespace"]
    given["namespace"] = None if namespace is None else namespace_from(namespace)
    try:
        return Options(goal=None if goal is None else _point(goal), **given)
    except ValueError:
        parser.error(f"--goal: got {' '.join(goal)}, expected two numbers X Y [m]")
