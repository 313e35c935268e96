"""The serial driver: frames per second, and the share of a core that the node takes at two rates."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from timing import Timed, time_each

from collplan_ros.bringup.network import graph_environment
from omnipuck_driver.codec import Decoder, Encoder
from omnipuck_driver.messages import NO_TEMPERATURE, CommandMessage, Message, Telemetry

RATES = (20.0, 100.0)
SETTLING, WATCHED = 2.0, 4.0
"""Time given to the driver to connect, and time over which its use of the processor is measured [s]."""
WHEELS = (-25.0, 0.0, 25.0)
COMMAND = CommandMessage(42, 1000, 20, 180, 0, 1, 2, WHEELS)
TELEMETRY = Telemetry(42, 7, 5000, 1, 7400, NO_TEMPERATURE, 1000, 5, 25, 3, 1, 2, 300, (-0.5, 0.25), 1, 2, WHEELS)
PUBLISHER = """
import rclpy
from geometry_msgs.msg import Twist
from collplan_ros.messages.qos import NEWEST
rclpy.init()
node = rclpy.create_node("commands")
publisher = node.create_publisher(Twist, "cmd_vel", NEWEST)
node.create_timer(0.05, lambda: publisher.publish(Twist()))
rclpy.spin(node)
"""


def protocol(rounds: int, frames: int = 2000) -> dict[str, Any]:
    """Time to encode and to decode one frame, and frames per second at the median."""
    figures: dict[str, Any] = {}
    for name, message in (("command", COMMAND), ("telemetry", TELEMETRY)):
        encoding, decoding = Timed(), Timed()
        for _ in range(rounds):
            encoding.rounds.append(time_each(Encoder().encode, [message] * frames))
            decoding.rounds.append(time_each(Decoder().feed, _stream(message, frames)))
        for way, timed in (("encode", encoding), ("decode", decoding)):
            summary = timed.summary()
            figures[f"{way}_{name}"] = {**summary, "frames_per_s": round(1e6 / summary["median_us"])}
    return figures


def _stream(message: Message, frames: int) -> list[bytes]:
    encoder = Encoder()
    return [encoder.encode(message) for _ in range(frames)]


def driver_cpu() -> dict[str, float]:
    """Share of a core that driver_node takes, by its rate; cmd_vel comes at 20 Hz, telemetry at 50 Hz."""
    return {f"{rate:g}_hz": _share(rate) for rate in RATES}


def _share(rate: float) -> float:
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        line = Path(folder) / "line"
        programs = Path(sys.executable).parent
        stack.enter_context(_running(programs / "firmware_emulator", "--ros-args", "-p", f"emulator.link:={line}"))
        stack.enter_context(_running(sys.executable, "-c", PUBLISHER))
        arguments = ["--ros-args", "-p", f"driver.port:={line}", "-p", f"driver.rate:={rate}"]
        driver = stack.enter_context(_running(programs / "driver_node", *arguments))
        time.sleep(SETTLING)
        started_at, before = time.monotonic(), _processor_time(driver.pid)
        time.sleep(WATCHED)
        return round((_processor_time(driver.pid) - before) / (time.monotonic() - started_at), 4)


@contextmanager
def _running(*command: object) -> Iterator[subprocess.Popen[bytes]]:
    quiet = {**graph_environment("local", os.environ), "ROS_DOMAIN_ID": "97"}
    process = subprocess.Popen([str(part) for part in command], env={**os.environ, **quiet}, stderr=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.terminate()
        process.wait()


def _processor_time(pid: int) -> float:
    """User and system time of a process so far [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
