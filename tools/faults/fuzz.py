"""Messages and frames of nonsense: nothing but refused, and never a command that is no number or too fast."""

import math
import random
from collections.abc import Callable
from contextlib import suppress
from itertools import count
from typing import Any

import numpy as np
from damaged_frames import damaged
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from sensor_msgs.msg import LaserScan

from collplan_core.goal import EXECUTING, Goal
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.parameters import Settings
from collplan_core.scan import Scan, ScanError
from collplan_core.sensing.mocap_body import robot_pose
from collplan_core.sensing.pose_filter import FRESH, PoseError, filter_pose
from collplan_core.state import State
from collplan_ros.messages.conversions import MessageError, scan_from_message
from collplan_ros.messages.mocap_formats import FORMATS
from collplan_ros.messages.plans import plan_from_path
from faults.fault import Fault, Measured
from omnipuck_driver.codec import Decoder, Encoder
from omnipuck_driver.framing import DELIMITER
from omnipuck_driver.messages import CommandMessage

MESSAGES, FRAMES = 1000, 10_000
"""Messages, and frames, of a case."""
PERIOD = 0.05
ODD = (math.nan, math.inf, -math.inf, 0.0, -0.0, 1e308, -1e308, 5e-324, 1e9, -1.0)
SETTINGS = Settings()
_seeds = count()


def number(drawn: random.Random, usual: float) -> float:
    """Mostly near what is usual, else anything."""
    return drawn.gauss(usual, 0.5) if drawn.random() < 0.7 else drawn.choice(ODD)


def single(drawn: random.Random, usual: float) -> float:
    """The same as a number of 32 bits, which is what a scan is made of."""
    with np.errstate(over="ignore"):
        return float(np.float32(number(drawn, usual)))


def pose(drawn: random.Random, now: float) -> PoseStamped:
    message = PoseStamped()
    message.header.frame_id = drawn.choice(["map", "map", "map", "odom", ""])
    message.header.stamp.sec, message.header.stamp.nanosec = stamp(drawn, now)
    for part, names in ((message.pose.position, "xyz"), (message.pose.orientation, "xyzw")):
        for name in names:
            setattr(part, name, number(drawn, float(name == "w")))
    return message


def stamp(drawn: random.Random, now: float) -> tuple[int, int]:
    """Seconds and nanoseconds, mostly of now."""
    seconds = int(now) if drawn.random() < 0.8 else drawn.randrange(-(2**31), 2**31)
    return seconds, int(1e9 * (now % 1.0)) if drawn.random() < 0.9 else drawn.randrange(2**32)


def scan(drawn: random.Random, now: float) -> LaserScan:
    message = LaserScan()
    message.header.frame_id = drawn.choice(["base_link", "base_link", "laser"])
    message.header.stamp.sec, message.header.stamp.nanosec = stamp(drawn, now)
    message.angle_min, message.angle_increment = single(drawn, -3.0), single(drawn, 0.02)
    message.range_min, message.range_max = single(drawn, 0.02), single(drawn, 6.0)
    message.time_increment = single(drawn, 0.0)
    message.ranges = [single(drawn, 2.0) for _ in range(drawn.choice([0, 1, 360]))]
    return message


def path(drawn: random.Random, now: float) -> Path:
    message = Path()
    message.header.frame_id = drawn.choice(["map", "map", "map", "odom"])
    message.header.stamp.sec, message.header.stamp.nanosec = stamp(drawn, now)
    for k in range(drawn.choice([0, 1, 2, 20])):
        point = pose(drawn, now + 0.1 * k)
        message.poses.append(point)
    return message


class Loop:
    """A controller with a goal, in a place where all is well but for what is put in."""

    def __init__(self) -> None:
        self.now = 1e5
        self.loop = ControllerLoop(SETTINGS)
        self.loop.take_goal(Goal(b"fuzz", self.now - 1.0, np.array([5.0, 0.0]), EXECUTING))

    def tick(self) -> str:
        """What is wrong with the command of a period that begins with a true pose and a true scan."""
        self.now += PERIOD
        ranges = np.full(360, 3.0)
        self.loop.take_pose(State(self.now, np.zeros(2), np.zeros(2), 0.0), self.now)
        angles = -math.pi, 2 * math.pi / 360
        self.loop.take_scan(Scan(self.now, *angles, 0.02, 6.0, ranges), self.now)
        return wrong(self.loop.tick(self.now))


def wrong(command: Any) -> str:
    """Why a command must not be sent; empty where it may."""
    speed = math.hypot(*command.velocity)
    finite = math.isfinite(speed) and math.isfinite(command.yaw_rate)
    return "" if finite and speed <= SETTINGS.robot.max_speed + 1e-9 else f"commanded {speed} m/s"


def poses(drawn: random.Random) -> str:
    memory, now = FRESH, 1e5
    for _ in range(MESSAGES):
        now += 0.01
        try:
            measured = FORMATS["pose"].read(pose(drawn, now), "")
            result, memory = filter_pose(memory, robot_pose(measured, now, SETTINGS.mocap), now, SETTINGS)
        except PoseError:
            continue
        state = result.state
        if state is not None and not np.isfinite([*state.position, *state.velocity, state.yaw]).all():
            return f"a pose of {state}"
    return ""


def scans(drawn: random.Random) -> str:
    looped = Loop()
    for _ in range(MESSAGES):
        with suppress(MessageError, ScanError):
            looped.loop.take_scan(scan_from_message(scan(drawn, looped.now), "base_link"), looped.now)
        if found := looped.tick():
            return found
    return ""


def paths(drawn: random.Random) -> str:
    looped = Loop()
    for _ in range(MESSAGES):
        with suppress(MessageError):
            looped.loop.take_plan(plan_from_path(path(drawn, looped.now), "map"), looped.now)
        if found := looped.tick():
            return found
    return ""


def frames(drawn: random.Random) -> str:
    decoder, encoder = Decoder(), Encoder()
    for n in range(FRAMES):
        wheels = tuple(drawn.randrange(-1280, 1280) / 16 for _ in range(3))  # whole in four bytes
        message = CommandMessage(7, n, 20, 180, 0, 0, n % 256, wheels)
        came = decoder.feed(damaged(encoder.encode(message), drawn) + DELIMITER)
        if any(each != message for each in came):
            return f"frame {n} was accepted as {came}"
    return ""


class Desk:
    """A bench without a robot."""

    def __enter__(self) -> "Desk":
        return self

    def __exit__(self, *exception: object) -> None:
        pass

    def drive(self) -> None:
        """Nothing."""


def fuzzed(name: str, batch: Callable[[random.Random], str], n: int, total: int) -> Fault:
    def measure(bench: object, seed: int) -> Measured:
        with np.errstate(all="ignore"):
            found = batch(random.Random(seed))
        return Measured(missed=f"seed {seed}: {found}" if found else "", n=n)

    return Fault(name, "desk", None, lambda bench: next(_seeds), measure, long=total, short=n)


FAULTS = [
    fuzzed("fuzzed poses: refused, or finite", poses, MESSAGES, 100_000),
    fuzzed("fuzzed scans: refused, or a command within the caps", scans, MESSAGES, 100_000),
    fuzzed("fuzzed Paths: refused, or a command within the caps", paths, MESSAGES, 100_000),
    fuzzed("damaged frames: none accepted", frames, FRAMES, 1_000_000),
]
