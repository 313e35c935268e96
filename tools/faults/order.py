"""Any node killed, frozen and restarted in any order, signals at any moment, and half hours: only in the long run."""

import io
import os
import signal
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path
from random import Random

from bringup_process import Run, nodes_of, wait_for
from diagnostic_msgs.msg import DiagnosticStatus

from collplan_ros.bringup.driving import wait_until_ready
from collplan_ros.bringup.main import Bringup
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.progress import Progress
from collplan_ros.messages.qos import EVENT
from collplan_ros.run.recorded_run import read_run
from faults.fault import Fault, Measured
from faults.live_graph import LiveGraph
from faults.runs import in_folder, nothing

BACK = 5.0
"""Longest time from the start of a node, or its release, until all streams are back [s]."""
FRESH = 0.3
"""A stream is back where its newest message is not older [s]."""
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
BUSY = [sys.executable, "-c", "while True: pass"]
"""A process that keeps a core busy."""
GROWTH = 1.05
"""Most that bringup's memory may grow between goals, as a share of what it was."""


def any_node(graph: LiveGraph) -> str:
    """Kills or freezes a node; which one."""
    chance = graph.chance
    node = chance.choice(list(graph.processes.pids))
    if chance.random() < 0.5:
        graph.freeze(node)
        graph.pause(chance.uniform(0.1, 2.0))
        graph.thaw(node)
    else:
        graph.kill(node)
        graph.pause(chance.uniform(0.1, 1.0))
    return node


def streams_back(graph: LiveGraph, node: str) -> Measured:
    begun = graph.now()
    if not graph.processes.runs(node):
        graph.restart(node)
    streams, robot = graph.streams, next(iter(graph.processes.pids))
    fresh = graph.until(lambda: streams.oldest(graph.now()) < FRESH and graph.healthy(robot), 3.0 * BACK)
    return Measured(graph.now() - begun if fresh else None)


def signalled(folder: Path, chance: Random) -> Measured:
    """A run that is stopped by a signal at any moment leaves no node, no traceback, and zero as the last command."""
    number = chance.choice(SIGNALS)
    with Run(folder / "runs", "--no-pictures") as run:
        wait_for(lambda: (run.out / "latest").is_symlink())
        if chance.random() < 0.7:
            wait_for(run.moving)
        time.sleep(chance.uniform(0.0, 3.0))
        ended = run.process.poll()
        run.process.send_signal(number)
        if chance.random() < 0.3:
            time.sleep(0.05)
            run.process.send_signal(number)
        code = run.end()
    said = run.text + "".join(log.read_text() for log in (run.out / "latest" / "log").iterdir())
    commands = read_run(run.out / "latest").log.sent_commands
    wrong = {
        f"exit code {code} after signal {number}": code != (128 + number if ended is None else 0),
        "a traceback": "Traceback" in said,
        "nodes outlive it": bool(nodes_of(run.out)),
        "the last command moves": bool(commands) and any(commands[-1][1:]),
    }
    return Measured(missed=", ".join(words for words, is_so in wrong.items() if is_so))


def between_goals(folder: Path) -> Measured:
    """Half an hour to and fro on busy cores: bringup's memory, and stops by the planner's heartbeat."""
    options = Options(world="l_corridor", strategy="bounce", out=folder / "runs", pictures=False, processes=True)
    sizes: list[int] = []
    stops: list[str] = []
    with ExitStack() as stack:
        for _ in range(os.cpu_count() or 1):
            stack.callback(subprocess.Popen(BUSY).kill)
        bringup = stack.enter_context(Bringup(options, Progress(io.StringIO())))
        listen = bringup.graph.listener.node.create_subscription
        listen(DiagnosticStatus, "controller/state", lambda message: stops.append(message.message), EVENT)
        wait_until_ready(bringup.graph)
        there, back = bringup.preparation.goal, bringup.preparation.world.start
        end = time.monotonic() + 60.0 * float(os.environ.get("COLLPLAN_MEMORY_MINUTES", "30"))
        while time.monotonic() < end:
            for goal in (there, back):
                bringup.drive(goal)
                bringup.come_to_rest()
                sizes.append(int(Path("/proc/self/statm").read_text().split()[1]))
    growth = max(sizes[len(sizes) // 10 :]) / sizes[len(sizes) // 10]
    silent = sum("heartbeat" in stop for stop in stops)
    wrong = {
        f"memory grew by {100 * (growth - 1):.1f} %": growth > GROWTH,
        f"{silent} stops by the heartbeat in {len(sizes)} goals": silent > 0,
    }
    return Measured(missed=", ".join(words for words, is_so in wrong.items() if is_so))


FAULTS = [
    *(
        Fault("any node killed and started, or frozen: streams back", robot, BACK, any_node, streams_back, short=0)
        for robot in ("simulator", "serial")
    ),
    Fault("signal to bringup at any moment", "process", None, nothing, in_folder(signalled), short=0),
    Fault(
        "half an hour between goals, cores busy: memory within 5 %, no stop by the heartbeat",
        "process",
        None,
        nothing,
        in_folder(between_goals),
        long=4,
        short=0,
    ),
]
