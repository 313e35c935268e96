"""Nodes without a loop on a clock of the test's own: one course from the start, in which a parameter may be set."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from called_nodes import ask, give, tick
from live_parameters import others, set_live
from rclpy.publisher import Publisher
from serial_robot import twist

from collplan_core.parameters.spec import Spec
from collplan_core.sensing.pose_filter import PoseSample
from collplan_core.state import State
from collplan_core.worlds import load_world
from collplan_ros.messages.conversions import pose_to_message, state_to_odometry
from collplan_ros.node_kit.clock import SteadyTimes
from collplan_ros.nodes import lidar_node, mocap_node
from collplan_ros.nodes.lidar_node import LidarNode
from collplan_ros.nodes.mocap_node import MocapNode
from omnipuck_driver import driver_node
from omnipuck_driver.driver_node import DriverNode
from omnipuck_driver.messages import WheelCaps
from omnipuck_driver.session import Permission, Session, WheelCommand
from omnipuck_sim.emulator import firmware_emulator
from omnipuck_sim.emulator.firmware_emulator import FirmwareEmulator
from omnipuck_sim.node import graph_pace, mocap_room
from omnipuck_sim.node.simulator_node import SimulatorNode

STEP = 0.01
"""Period of the poses [s]."""
SET_AT = 0.5
"""When the parameter is set [s]."""
TOPICS = ("mocap/odom", "mocap/refused", "impact", "impact/contact", "scan", "mocap/pose", "ground_truth/odom")
"""What is listened to; diagnostics hold parameters themselves."""


class Bench:
    """A clock that the nodes go by, and what comes out of them.

    Attributes:
        now: the time [s].
        out: topic and message, or what else leaves a node.
    """

    def __init__(self, ros, patched: pytest.MonkeyPatch) -> None:
        self.now = 0.0
        self.out: list[object] = []
        self.ros, self.patched = ros, patched
        for module in (lidar_node, mocap_node, driver_node, mocap_room, graph_pace):
            patched.setattr(module, "seconds", lambda clock: self.now)
        patched.setattr(mocap_room, "monotonic", lambda: self.now)
        patched.setattr(SteadyTimes, "now", lambda times: self.now)
        patched.setattr(Publisher, "publish", lambda publisher, message: self._take(publisher.topic_name, message))

    def _take(self, topic: str, message: object) -> None:
        if topic.removeprefix("/") in TOPICS:
            self.out.append((topic, message))

    def times(self, end: float) -> Iterator[float]:
        """Goes through time until `end` [s]."""
        for k in range(1, round(end / STEP) + 1):
            self.now = max(self.now, k * STEP)
            yield self.now


Change = Callable[[object], None]
"""Called with the node before each step."""


def measured_poses() -> Iterator[tuple[float, PoseSample]]:
    """Time and pose of a robot that bumps hard and lightly, is unseen, leaps a little, and is carried away."""
    random = np.random.default_rng(0)
    place, velocity = np.zeros(2), np.array([0.8, 0.1])
    for k in range(1, 480):
        now = k * STEP
        velocity = {130: np.array([-0.6, 0.1]), 180: np.array([-0.6, 0.32])}.get(k, velocity)
        place = place + velocity * STEP + {250: np.array([0.055, 0.0]), 340: np.array([2.0, 1.0])}.get(k, 0.0)
        if not 220 <= k < 230:
            yield now, PoseSample(now, place + random.normal(0.0, 0.002, 2), 0.02 * np.sin(now))


def mocap_course(bench: Bench, change: Change) -> None:
    node = bench.ros.make(MocapNode)
    held = None
    for now, sample in measured_poses():
        bench.now = now
        change(node)
        message = pose_to_message(sample, "map")
        if 2.8 <= now < 3.1:
            held = held or message.pose
            message.pose = held
        if 3.2 <= now < 3.25:
            message.pose.orientation.w *= 1.005
        give(node, "mocap/pose", message)
    bench.ros.remove(node)


def lidar_course(bench: Bench, change: Change) -> None:
    node = bench.ros.make(LidarNode)
    start = State(0.0, np.array(load_world("corridor").start, dtype=float), np.zeros(2), 0.4)
    for now in bench.times(1.2):
        change(node)
        # one scan is made from a pose that is 0.04 s old
        if not 0.615 < now < 0.695:
            give(node, "mocap/odom", state_to_odometry(replace(start, stamp=now), "map", "base_link"))
        if round(now / STEP) % 5 == 0:
            tick(node, 5 * STEP)
    bench.ros.remove(node)


def _commanded(bench: Bench, node, change: Change, period: float) -> None:
    """Commands of 1 m/s at 20 Hz to a robot that a person lets move, whose timer has this period [s]."""
    for now in bench.times(1.2):
        change(node)
        if round(now / STEP) % 5 == 0:
            give(node, "cmd_vel", twist(1.0), now)
        if now == STEP:
            ask(node, "resume")
        tick(node, period)
    bench.ros.remove(node)


def simulator_course(bench: Bench, change: Change) -> None:
    _commanded(bench, bench.ros.make(SimulatorNode), change, STEP)


class _GoodLink:
    """A firmware that follows whatever it is sent."""

    armed = True

    def __init__(self, sent: list[object]) -> None:
        self._sent = sent
        self.session = SimpleNamespace(begun=1, connected=True, telemetry=None)

    def trouble(self) -> str:
        return ""

    def receive(self, now: float) -> list:
        return []

    def send(self, wheel_command: WheelCommand, permission: Permission, now: float) -> None:
        self._sent.append((wheel_command, permission))

    def close(self) -> None:
        pass


def driver_course(bench: Bench, change: Change) -> None:
    node = bench.ros.make(DriverNode)
    node.link = _GoodLink(bench.out)
    _commanded(bench, node, change, 2 * STEP)


class _Line:
    """A cable to the emulated firmware. All that are plugged in at a time share what was sent."""

    sent, is_there = b"", True

    def __init__(self, out: list[object]) -> None:
        self.received = b""
        self._out = out

    def read(self) -> bytes:
        data, self.sent = self.sent, b""
        return data

    def write(self, data: bytes) -> None:
        self._out.append(data)
        self.received += data

    def rate_is(self, baud: int) -> bool:
        return True

    def close(self) -> None:
        self.is_there = False
        self._out.append("unplugged")


def emulator_course(bench: Bench, change: Change) -> None:
    lines: list[_Line] = []

    def plugged(path: object) -> _Line:
        lines.append(_Line(bench.out))
        return lines[-1]

    bench.patched.setattr(firmware_emulator, "PseudoTerminal", plugged)
    bench.patched.setattr(firmware_emulator.secrets, "randbits", lambda n: 1)

    def sleep(duration: float) -> None:
        bench.now += duration

    bench.patched.setattr(firmware_emulator, "time", SimpleNamespace(sleep=sleep))
    node = bench.ros.make(FirmwareEmulator)
    session = Session(3, 0.3, WheelCaps(40.0, 400.0), new_token=lambda: 7)
    for now in bench.times(1.5):
        change(node)
        line = lines[-1]
        if line.is_there:
            session.receive(line.received, now)
            line.received = b""
            driving = WheelCommand((10.0, -10.0, 0.0), 0.0, 0.2)
            line.sent += session.outgoing(driving, Permission(False, now < 0.2, 0, int(now >= 0.2)), now)
        tick(node, STEP)
    bench.ros.remove(node)


COURSES: dict[type, Callable[[Bench, Change], None]] = {
    MocapNode: mocap_course,
    LidarNode: lidar_course,
    SimulatorNode: simulator_course,
    DriverNode: driver_course,
    FirmwareEmulator: emulator_course,
}


def came_out(ros, kind: type, values: dict[str, object]) -> list[object]:
    """All that comes out of a node of this kind in its course, in which these values are set at SET_AT."""
    left = dict(values)
    with pytest.MonkeyPatch.context() as patched:
        bench = Bench(ros, patched)

        def change(node) -> None:
            if left and bench.now >= SET_AT:
                set_live(node, left)
                left.clear()

        COURSES[kind](bench, change)
    return bench.out


def changes_course(ros, kind: type) -> Callable[[Spec], bool]:
    """Whether another value of a parameter changes what comes out of a node of this kind after it was set."""
    unchanged = came_out(ros, kind, {})
    assert unchanged == came_out(ros, kind, {}), "equal nodes differ"
    return lambda spec: any(came_out(ros, kind, {spec.key: value}) != unchanged for value in others(spec))
