"""Command line of bringup."""

import argparse
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from collplan_core.command_line import as_called, examples
from collplan_core.parameters import Settings, all_specs
from collplan_core.planners import PLANNERS
from collplan_ros.bringup.failures import StartError
from collplan_ros.bringup.network import RANGES
from collplan_ros.bringup.robots import EXPECTED, FIRST_SPEED, LOCKSTEP, REAL, SIM, robot_kind
from collplan_ros.node_kit.node_names import namespace_from


@dataclass(frozen=True)
class Options:
    """Options of one run. None leaves a value to the parameter file, or else to the parameter's default.

    Attributes:
        robot: sim, emulator, serial:PATH or serial:PATH@BAUD.
        world: NAME, FILE or FAMILY:SEED.
        strategy: name of a strategy.
        goal: x, y [m]; None is the world's own.
        engine: simulator.engine, which computes the contacts.
        seed: seed of every random number of the simulator and its LIDAR.
        params: ROS parameter file.
        out: parent of the run folder.
        timeout: longest run [s].
        network: local or subnet; None is the robot's own, where it has one.
        max_speed: robot.max_speed [m/s].
        pictures: whether trajectory.png and run.html are made.
        scan: sim or real, whose scans the robot drives by: those of lidar_node, or of a LIDAR that somebody else runs.
        check: whether the robot and its motion capture are checked instead of a run.
        yes: whether the check may move the robot without asking.
        view: whether view_node shows the run in a browser.
        again: whether the robot drives there and back until it is interrupted.
        namespace: of all nodes, with its leading slash.
        real_time: whether a simulation does not wait for its graph.
    """

    robot: str = "sim"
    world: str | None = None
    strategy: str | None = None
    goal: tuple[float, float] | None = None
    engine: str | None = None
    seed: int | None = None
    params: Path | None = None
    out: Path = Path("runs")
    timeout: float | None = None
    network: str | None = None
    max_speed: float | None = None
    pictures: bool = True
    scan: str = SIM
    check: bool = False
    yes: bool = False
    view: bool = False
    again: bool = False
    namespace: str = "/"
    real_time: bool = False

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
            LOCKSTEP: False if self.real_time else None,
        }
        return {key: value for key, value in chosen.items() if value is not None}

    def repeat(self, goal: np.ndarray, parameters: Path) -> str:
        """The command line that repeats the run; it gives goal (2,) [m] and robot, which no parameter file holds."""
        # argparse takes -1e-05 for an option
        x, y = (np.format_float_positional(value, trim="0") for value in goal)
        network = ["--network", self.network] if self.network else []
        # a robot that is not simulated wants it said
        world = ["--world", self.world] if self.world else []
        said = [] if robot_kind(self.robot).simulated else [*world, *self._speed]
        namespace = [] if self.namespace == "/" else ["--namespace", self.namespace]
        scan = [] if self.scan == SIM else ["--scan", self.scan]
        where = [*network, *namespace, *scan]
        given = ["--robot", self.robot, *where, *said, "--params", str(parameters), "--goal", x, y]
        return shlex.join([as_called("bringup"), *given])

    @property
    def _speed(self) -> list[str]:
        return [] if self.max_speed is None else ["--max-speed", f"{self.max_speed:g}"]


DESCRIPTION = """\
Starts a robot and the nodes that plan and control it, gives it a goal, and watches until it is there.

The goal is reached: exit code 0. Time is up, stuck or given up: 1. Something asked for cannot be done: 2.
A node died, the graph did not come up, somebody else commands the robot or this machine is too slow for it: 3.
A file of the run cannot be written, as on a full disk: 4.
Stopped by a signal: 128 + its number; by Ctrl-C with --again: 0.

A robot that is not simulated needs --world, --goal and --network, and drives at 0.3 m/s at most unless --max-speed
says otherwise: a parameter file may lower that, not raise it. With --scan real it needs no --world: what is there, its
LIDAR shows.
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
  bringup --params runs/latest/parameters.yaml --goal 2.0 0.4
      the last run's parameters, and a goal: no file holds one
  bringup --check --robot serial:/dev/ttyUSB0 --network subnet --params mocap.yaml
      before the first run of a robot

Each run leaves a folder: run.html, which plays it in a browser, trajectory.png and .csv, impacts.csv, summary.json,
parameters.yaml, the output of each node in log/, and run.mcap, which holds every topic and is written during the run.
What a bringup that was killed has left the next one completes. The command line that repeats the run is printed at its
end, and is in summary.json.
ROS_DOMAIN_ID is left as it is set; several robots fit in a domain, each with a --namespace of its own.
"""


def _parser() -> argparse.ArgumentParser:
    defaults = Settings()
    parser = argparse.ArgumentParser(
        prog="bringup",
        usage="%(prog)s [options], which --help lists",
        description=DESCRIPTION,
        epilog=examples(EPILOG),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--robot", default="sim", type=_robot, help=f"{EXPECTED} (default sim, the simulated one)")
    add("--world", metavar="W", help=f"world: NAME, FILE or FAMILY:SEED (default {defaults.simulator.world})")
    add("--strategy", metavar="NAME", help=f"{' | '.join(PLANNERS)} (default {defaults.planner.strategy})")
    add("--goal", nargs="+", metavar=("X", "Y"), help="where to go [m] (default the world's own goal)")
    add(
        "--engine",
        metavar="NAME",
        help=f"simulator.engine: {' | '.join(all_specs()['simulator.engine'].choices)} "
        f"(default {defaults.simulator.engine})",
    )
    add("--seed", type=int, metavar="N", help=f"seed of the simulated noise (default {defaults.simulator.seed})")
    add("--params", type=Path, metavar="FILE", help="ROS parameter file; the options above and below outrank it")
    add("--out", type=Path, default=Path("runs"), metavar="DIR", help="where run folders go (default runs)")
    add("--timeout", type=float, metavar="S", help=f"longest run [s] (default {defaults.trial.timeout:g})")
    add(
        "--network",
        choices=sorted(RANGES),
        help="who may take part: this machine or the subnet (default local; to be said for serial)",
    )
    add(
        "--max-speed",
        type=float,
        metavar="V",
        help=f"robot.max_speed (default {defaults.robot.max_speed:g} m/s; for serial {FIRST_SPEED:g} or less)",
    )
    add(
        "--namespace",
        default="/",
        type=_namespace,
        metavar="NAME",
        help="of all nodes and topics, as robot1: one for each robot of a domain (default none)",
    )
    add("--no-pictures", dest="pictures", action="store_false", help="leave out trajectory.png and run.html")
    add(
        "--scan",
        choices=(SIM, REAL),
        default=SIM,
        help="whose scans: of lidar_node, which casts rays in the world, or of a real LIDAR (default sim)",
    )
    add(
        "--real-time",
        action="store_true",
        help="do not let the simulation wait for nodes that are late (simulator.lockstep: false)",
    )
    add("--check", action="store_true", help="check link, motion capture, axes and LIDAR instead, and find offsets")
    add("--yes", action="store_true", help="with --check: move the robot without asking")
    add("--view", action="store_true", help="show the run in a browser, at the address that is said (view.port)")
    add("--again", action="store_true", help="drive there and back again and again until Ctrl-C; simulated robots only")
    return parser


def _robot(spec: str) -> str:
    try:
        robot_kind(spec)
    except StartError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return spec


def _namespace(text: str) -> str:
    try:
        return namespace_from(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _point(words: Sequence[str]) -> tuple[float, float]:
    x, y = (float(number) for number in " ".join(words).replace(",", " ").split())
    return x, y


def parse(args: Sequence[str] | None = None) -> Options:
    """The options on a command line without the program's name; sys.argv's when None."""
    parser = _parser()
    given = vars(parser.parse_args(args))
    goal = given.pop("goal")
    try:
        return Options(goal=None if goal is None else _point(goal), **given)
    except ValueError:
        parser.error(f"--goal: got {' '.join(goal)}, expected two numbers X Y [m]")
