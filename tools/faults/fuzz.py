"""Messages and frames of nonsense: nothing but refused, and never a command that is no number or too fast."""

import math
import random
from array import array
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np
import pytest
from damaged_frames import damaged
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.serialization import serialize_message
from sensor_msgs.msg import LaserScan

from collplan_core.command import Command
from collplan_core.loop.decisions import Cycle, Decision
from collplan_core.parameters import Settings
from collplan_core.scan import Scan, ScanError
from collplan_core.sensing.mocap_body import robot_pose
from collplan_core.sensing.pose_filter import FRESH, PoseError, filter_pose
from collplan_core.worlds import load_world
from collplan_ros.messages.mocap_formats import FORMATS
from collplan_ros.messages.raw_reading import plan_from_path
from collplan_ros.messages.reading import MessageError, scan_from_message
from faults.fault import Fault, Measured
from faults.trials import STRATEGY, seed_of, world
from omnipuck_driver.codec import Decoder, Encoder
from omnipuck_driver.framing import DELIMITER
from omnipuck_driver.messages import CommandMessage
from omnipuck_sim import trial
from omnipuck_sim.trial_record import TrialRecord

MESSAGES, FRAMES = 1000, 10_000
"""Messages, and frames, of a case."""
AT_ONCE = 5
"""Messages of nonsense before planner or controller acts."""
DROVE = 20
"""Fewest commands that move the robot in a trial: one that stands would tell nothing."""
ODD = (math.nan, math.inf, -math.inf, 0.0, -0.0, 1e308, -1e308, 5e-324, 1e9, -1.0)
SETTINGS = Settings().with_values({"planner.strategy": STRATEGY})


class Wrong(Exception):
    """What came of nonsense and must not."""


class Nonsense(random.Random):
    """Numbers that are mostly near what is usual.

    Attributes:
        share: of numbers that are anything; drawn anew for each message.
    """

    share = 0.0

    def begin(self) -> None:
        """Begins a message."""
        self.share = self.choice((0.003, 0.03, 0.3))

    def is_odd(self) -> bool:
        """Whether the next one is nonsense."""
        return self.random() < self.share

    def number(self, usual: float, spread: float = 0.0) -> float:
        """Mostly near what is usual, else anything."""
        return self.choice(ODD) if self.is_odd() else self.gauss(usual, spread)

    def single(self, usual: float) -> float:
        """The same as a number of 32 bits, which is what a scan is made of."""
        return float(np.float32(self.number(usual)))

    def stamp(self, message: Any, now: float) -> None:
        """Stamps a message, mostly with `now` [s]."""
        message.header.stamp.sec = self.randrange(-(2**31), 2**31) if self.is_odd() else int(now)
        message.header.stamp.nanosec = self.randrange(2**32) if self.is_odd() else int(1e9 * (now % 1.0))


def pose(drawn: Nonsense, now: float, x: float = 0.0, y: float = 0.0, spread: float = 0.5) -> PoseStamped:
    message = PoseStamped()
    message.header.frame_id = "odom" if drawn.is_odd() else "map"
    drawn.stamp(message, now)
    position, orientation = message.pose.position, message.pose.orientation
    position.x, position.y, position.z = (drawn.number(usual, spread) for usual in (x, y, 0.0))
    for name in "xyzw":
        setattr(orientation, name, drawn.number(float(name == "w"), 0.1))
    return message


def scan(drawn: Nonsense, true: Scan) -> LaserScan:
    """A true scan with nonsense in it."""
    message = LaserScan()
    message.header.frame_id = "laser" if drawn.is_odd() else "base_link"
    drawn.stamp(message, true.stamp)
    n = drawn.choice((0, 1, 7)) if drawn.is_odd() else len(true.ranges)
    message.angle_min, message.angle_increment = drawn.single(true.angle_min), drawn.single(true.angle_increment)
    message.angle_max = drawn.single(true.angle_min + (n - 1) * true.angle_increment)
    message.range_min, message.range_max = drawn.single(true.range_min), drawn.single(true.range_max)
    message.time_increment = drawn.single(true.time_increment)
    message.ranges = array("f", (drawn.single(each) for each in true.ranges[:n]))
    return message


def path(drawn: Nonsense, now: float, x: float, y: float) -> Path:
    """A way from x, y on with nonsense in it."""
    message = Path()
    message.header.frame_id = "odom" if drawn.is_odd() else "map"
    drawn.stamp(message, now)
    n = drawn.choice((0, 1, 2, 20))
    message.poses = [pose(drawn, now + 0.1 * k, x + 0.1 * k, y, 0.02) for k in range(n)]
    return message


def poses(seed: int) -> int:
    drawn, memory, now = Nonsense(seed), FRESH, 1e5
    for _ in range(MESSAGES):
        drawn.begin()
        now += 0.01
        try:
            measured = FORMATS["pose"].read(pose(drawn, now), "")
            result, memory = filter_pose(memory, robot_pose(measured, now, SETTINGS.mocap), now, SETTINGS)
        except PoseError:
            continue
        state = result.state
        if state is not None and not np.isfinite([*state.position, *state.velocity, state.yaw]).all():
            raise Wrong(f"a pose of {state}")
    return MESSAGES


def put_scan(nodes: trial.TrialNodes, drawn: Nonsense, true: Scan) -> None:
    try:
        taken = scan_from_message(scan(drawn, true), "base_link")
    except ScanError as error:
        nodes.loop.planner.refuse("scan", str(error))
        nodes.loop.controller.refuse("scan", str(error))
        return
    nodes.loop.take_scan(taken, nodes.simulator.time)


def put_path(nodes: trial.TrialNodes, drawn: Nonsense, true: Scan) -> None:
    with suppress(MessageError):
        message = path(drawn, true.stamp, *nodes.simulator.state.position.tolist())
        nodes.loop.controller.take_plan(plan_from_path(serialize_message(message), "map"), nodes.simulator.time)


def in_trial(put: Callable[[trial.TrialNodes, Nonsense, Scan], None], seed: int) -> int:
    """A trial in which planner and controller get nonsense before they act, as their nodes would; how many messages."""
    drawn, moved, n = Nonsense(seed), 0, 0
    newest: Scan | None = None
    take_scan, hear = trial.TrialNodes._take_scan, trial.TrialNodes._hear
    commanded = TrialRecord.commanded

    def take(nodes: trial.TrialNodes, true: Scan) -> None:
        nonlocal newest
        newest = true
        take_scan(nodes, true)

    def after_nonsense(act: Callable[[trial.TrialNodes], None]) -> Callable[[trial.TrialNodes], None]:
        def acting(nodes: trial.TrialNodes) -> None:
            nonlocal n
            for _ in range(AT_ONCE if newest else 0):
                drawn.begin()
                put(nodes, drawn, newest)
                n += 1
            act(nodes)

        return acting

    def planned(nodes: trial.TrialNodes, decision: Decision, local: float) -> None:
        if isinstance(decision, Cycle):
            plan = decision.plan
            if not all(np.isfinite(each).all() for each in (plan.times, plan.positions, plan.velocities)):
                raise Wrong(f"a plan of {plan.positions}")
        hear(nodes, decision, local)

    def judged(record: TrialRecord, command: Command, now: float) -> None:
        nonlocal moved
        speed = math.hypot(*command.velocity)
        if not (math.isfinite(command.yaw_rate) and speed <= SETTINGS.robot.max_speed + 1e-9):
            raise Wrong(f"commanded {speed} m/s, {command.yaw_rate} rad/s")
        moved += speed > 0.0
        commanded(record, command, now)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(trial.TrialNodes, "_take_scan", take)
        patched.setattr(trial.TrialNodes, "planner", after_nonsense(trial.TrialNodes.planner))
        patched.setattr(trial.TrialNodes, "controller", after_nonsense(trial.TrialNodes.controller))
        patched.setattr(trial.TrialNodes, "_hear", planned)
        patched.setattr(TrialRecord, "commanded", judged)
        trial.run_trial(load_world(world(seed)), SETTINGS, seed)
    if moved < DROVE:
        raise Wrong(f"only {moved} commands moved the robot")
    return n


def frames(seed: int) -> int:
    drawn, decoder, encoder = random.Random(seed), Decoder(), Encoder()
    for n in range(FRAMES):
        wheels = tuple(drawn.randrange(-1280, 1280) / 16 for _ in range(3))  # whole in four bytes
        message = CommandMessage(7, n, 20, 180, 0, 0, n % 256, wheels)
        came = decoder.feed(damaged(encoder.encode(message), drawn) + DELIMITER)
        if any(each != message for each in came):
            raise Wrong(f"frame {n} was accepted as {came}")
    return FRAMES


def fuzzed(name: str, batch: Callable[[int], int], n: int, total: int) -> Fault:
    """A row of at least n messages, in the long run `total`; `batch` does those of a seed and tells how many."""

    def measure(bench: object, seed: int) -> Measured:
        try:
            with np.errstate(all="ignore"):
                return Measured(n=batch(seed))
        except Exception as error:
            return Measured(missed=f"seed {seed}: {type(error).__name__} {error}")

    return Fault(name, "desk", None, seed_of, measure, long=total, short=n)


FAULTS = [
    fuzzed("fuzzed poses: refused, or finite", poses, MESSAGES, 100_000),
    fuzzed(
        "fuzzed scans: refused, or plans and commands within the caps", partial(in_trial, put_scan), MESSAGES, 100_000
    ),
    fuzzed("fuzzed Paths: refused, or a command within the caps", partial(in_trial, put_path), MESSAGES, 100_000),
    fuzzed("damaged frames: none accepted", frames, FRAMES, 1_000_000),
]
