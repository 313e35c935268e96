"""A base without our firmware, behind base_node: the foreign robot of tests/foreign, in a hall."""

import os
import signal
import subprocess
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import yaml
from std_msgs.msg import String

import foreign_robot
from collplan_ros.bringup.options import COMMANDER, Options
from collplan_ros.messages.qos import EVENT
from collplan_ros.messages.states import HELD
from collplan_ros.node_kit.reachability import environment_set
from collplan_ros.nodes.localisation import LONGEST_SILENCE
from faults.live_graph import WAIT, LiveGraph
from faults.runner import Act, BenchError, Fault, Measure, Measured
from faults.stands import commanded_to_stand
from rooms import LIDAR_AT, Room

HALL = Room((16.0, 3.2), (2.0, 1.6), ((14.0, 1.6),), ())
SWITCH = "/fault"
"""Topic of the fault that the base is to have."""
SILENCE, LONG = 0.25, 1.5
"""Longest time from the last pose to zero, and until it is held: so long it is watched when the base is back [s]."""


class BaseGraph(LiveGraph):
    """A bench: its robot is another process, which bringup knows by its topics alone."""

    ends = np.array(HALL.start), np.array(HALL.goals[0])
    fast, strategy = 0.7, "avoid"
    topics = "/cmd_vel", "/truth"

    def __init__(self) -> None:
        super().__init__("base:/cmd_vel")

    def _options(self, robot: str, folder: Path) -> Options:
        file = folder / "parameters.yaml"
        lidar = dict(zip(("offset_x", "offset_y", "offset_yaw"), LIDAR_AT, strict=True))
        given = {**foreign_robot.PARAMETERS, "scan": {"frame": "laser", **lidar}}
        file.write_text(yaml.safe_dump({"/**": {"ros__parameters": given}}), encoding="utf-8")
        top = foreign_robot.PARAMETERS["robot"]["max_speed"]
        asked = {"goal": HALL.goals[0], "scan": "real", "network": "local", "max_speed": top}
        return Options(robot=robot, params=file, processes=True, **asked)

    def __enter__(self) -> "BaseGraph":
        if why := foreign_robot.missing():
            raise BenchError(f"the robot of tests/foreign cannot run: {why}")
        self._around = ExitStack()
        self._around.enter_context(environment_set(foreign_robot.environment()))
        self.base: subprocess.Popen[bytes] | None = None
        self.start_base()
        super().__enter__()
        self._faults = self.listener.node.create_publisher(String, SWITCH, EVENT)
        return self

    def __exit__(self, *exception: object) -> None:
        super().__exit__(*exception)
        self.end_base()
        self._around.close()

    def start_base(self) -> None:
        """Starts its process, where it does not run."""
        if self.base is None:
            self.base = foreign_robot.start(HALL, Path(self._temporary.name) / "room.yaml")

    def end_base(self) -> None:
        """Kills its process."""
        if self.base is not None:
            self.base.kill()
            self.base.wait()
            self.base = None

    def signal_base(self, number: int) -> float:
        """Sends its process a signal; returns when [s, steady clock]."""
        begun = self.now()
        if self.base is not None:
            os.kill(self.base.pid, number)
        return begun

    def tell_base(self, fault: str) -> float:
        """Switches its fault of this name on, "" for none; returns when it last sent without it [s, steady clock].

        BenchError: it does not take it. A base that is held up, or behind its own time, goes on sending meanwhile.
        """
        truth, begun = self.streams.truth, self.now()
        self._faults.publish(String(data=fault))
        if not self.until(lambda: truth[-1].frame == fault, WAIT):
            raise BenchError(f"the base does not take the fault {fault!r}")
        return next((row.sent for row in reversed(truth) if row.frame != fault), begun)

    def why_not_held(self, words: str = "") -> str:
        """Says that neither robot nor controller is held, or for another reason than these words; empty where so."""

        def reasons() -> list[str]:
            robot = self.streams.states[-1].why if self.state == HELD else ""
            return [why for why in (robot, self.value(COMMANDER, "held")) if why]

        held = self.until(lambda: any(words in why for why in reasons()), WAIT)
        return "" if held else f"it is not held: {reasons()}"


def telling(fault: str) -> Act:
    return lambda graph: graph.tell_base(fault)


def well(graph: BaseGraph) -> None:
    """Takes away whatever was done to the base."""
    graph.signal_base(signal.SIGCONT)
    graph.start_base()
    graph.tell_base("")
    graph.rest()


def dead_and_back(number: int) -> tuple[Act, Measure]:
    """Zero is sent, and once it runs again it rests, is held, and does not move; frozen its wheels go on meanwhile."""

    def measure(graph: BaseGraph, begun: float) -> Measured:
        measured, streams = commanded_to_stand(0.6)(graph, begun), graph.streams
        if number == signal.SIGKILL:
            graph.end_base()
            graph.start_base()
        again = graph.signal_base(signal.SIGCONT)
        came = graph.until(lambda: streams.truth[-1].sent > again, 10.0)
        graph.rest()
        rested = graph.now()
        graph.pause(LONG)
        wrong = ("" if came else "it is not back"), streams.why_moved(rested), graph.why_not_held()
        way = None if number == signal.SIGKILL else streams.speed_and_way(begun)["distance"]
        return measured.then(*wrong, distance=way)

    return (lambda graph: graph.signal_base(number)), measure


def held_for(words: str, hold: float) -> Measure:
    """Measures the time until zero is sent, and whether it is held after LONG for a reason with these words."""
    measure = commanded_to_stand(hold + LONG)
    return lambda graph, begun: measure(graph, begun).then(graph.why_not_held(words))


def row(name: str, limit: float, act: Act, measure: Measure) -> Fault:
    return Fault(name, "base", limit, act, measure, well)


UNLOCALISED = held_for("no transform from map to odom", LONGEST_SILENCE)
FAULTS = [
    row("base's process frozen, it runs again: held", SILENCE, *dead_and_back(signal.SIGSTOP)),
    row("base's process killed and started: held", SILENCE, *dead_and_back(signal.SIGKILL)),
    row("base sends nothing any more, but obeys: held", SILENCE, telling("silent"), held_for("", 0.0)),
    row("localisation silent: held, by its name", LONGEST_SILENCE + SILENCE, telling("unlocalised"), UNLOCALISED),
]
