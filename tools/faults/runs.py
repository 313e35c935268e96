"""Runs of bringup that end while the robot drives, are killed, or whose disk is full."""

import io
import math
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from random import Random

from bringup_process import Run, nodes_of, wait_for

from collplan_core.evaluation.run_end import STUCK, TIMEOUT
from collplan_core.parameters import Settings
from collplan_ros.bringup.driving import wait_until_ready
from collplan_ros.bringup.failures import RECORD_LOST
from collplan_ros.bringup.main import Bringup
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.progress import Progress
from collplan_ros.run.completion import complete
from collplan_ros.run.recorded_run import read_run
from faults.bench import Bench
from faults.fault import Fault, Measured
from faults.live_graph import ENDS, HALL
from faults.streams import Streams, why_stalled

AT_ONCE = 0.1
"""Longest time from the outcome of a run to the first zero command [s]."""
LOST = 1.0
"""What a killed bringup may lose of a run at most [s]."""
ORPHANS = 5.0
"""Longest time for which a node outlives bringup [s]."""
FULL = """
import resource, sys
from pathlib import Path
from threading import Timer
from collplan_ros.bringup.main import main
from collplan_ros.run.writer import RECORDING
from collplan_ros.run.recorder import Recorder

begin = Recorder.begin

def fill():
    folder = Path(sys.argv[sys.argv.index("--out") + 1])
    held = max(file.stat().st_size for file in folder.rglob(RECORDING))
    resource.setrlimit(resource.RLIMIT_FSIZE, (held, resource.RLIM_INFINITY))

def full(self, *given):
    begin(self, *given)
    Timer(1.5, fill).start()

Recorder.begin = full
sys.exit(main(sys.argv[1:]))
"""
"""bringup on a disk that is full 1.5 s after the run has begun: of poses at 100 Hz 50 are over a second old by then."""
EARLY = {TIMEOUT: {"timeout": 1.5}, STUCK: {"stuck_time": 0.8, "stuck_distance": 5.0}}
"""Under which a run ends while the robot drives."""


class RunEnds(Bench):
    """A bench: one bringup, whose runs end one after the other on the graph that it keeps up."""

    def __init__(self) -> None:
        self._temporary = tempfile.TemporaryDirectory(prefix="faults-", ignore_cleanup_errors=True)
        folder = Path(self._temporary.name)
        (folder / "hall.yaml").write_text(HALL, encoding="utf-8")
        self._bringup = Bringup(
            Options(world=str(folder / "hall.yaml"), out=folder / "runs", pictures=False, processes=True),
            Progress(io.StringIO()),
        )

    def __enter__(self) -> "RunEnds":
        self._bringup.__enter__()
        wait_until_ready(self._bringup.graph)
        self.streams = Streams(self._bringup.graph.listener.node)
        return self

    def __exit__(self, *exception: object) -> None:
        self._bringup.__exit__(None, None, None)
        self._temporary.cleanup()

    def ended(self, outcome: str) -> tuple[str, float]:
        """The outcome of a run that is to end so, and when it was known [s, steady clock]."""
        bringup = self._bringup
        trial = replace(Settings().trial, **EARLY[outcome])
        bringup.preparation = replace(bringup.preparation, settings=replace(bringup.preparation.settings, trial=trial))
        here = bringup.graph.pose
        said = bringup.drive(max(ENDS, key=lambda end: math.hypot(here.x - end[0], here.y - end[1])))
        at = time.monotonic()
        bringup.come_to_rest()
        return said, at


def ending(outcome: str) -> Fault:
    def act(bench: RunEnds) -> tuple[str, float]:
        return bench.ended(outcome)

    def measure(bench: RunEnds, ended: tuple[str, float]) -> Measured:
        said, at = ended
        if said != outcome:
            return Measured(missed=f"the run ended as {said}")
        streams = bench.streams
        zero = streams.stands_from(at)
        speed, way = streams.motion_at(at).speed, streams.way_since(at)
        # the planner cancels, and the controller commands
        stalled = why_stalled("planner_node", streams.beats, at, zero or at)
        stalled = stalled or why_stalled("controller_node", (row.sent for row in streams.commands), at, zero or at)
        return Measured(None if zero is None else zero - at, "", stalled, streams.why_stood(at), speed, way)

    return Fault(f"run ended by {outcome.upper()}", "bringup", AT_ONCE, act, measure)


def in_folder(measured: Callable[[Path, Random], Measured]) -> Callable[[Bench, object], Measured]:
    def measure(bench: Bench, nothing: object) -> Measured:
        with tempfile.TemporaryDirectory(prefix="faults-", ignore_cleanup_errors=True) as folder:
            try:
                return measured(Path(folder), bench.chance)
            except AssertionError as error:  # what should have come in time did not
                return Measured(missed=str(error))

    return measure


def killed(folder: Path, chance: Random) -> Measured:
    """How much of a run that was killed is not on disk: time from its newest pose there to the kill."""
    with Run(folder / "runs", "--no-pictures", "--real-time", "--world", "serpentine:0") as run:
        wait_for(run.moving)
        # a run that is killed within its first second may leave nothing
        wait_for(run.has_recorded)
        time.sleep(chance.uniform(0.0, 2.0))
        run.process.kill()
        at = time.monotonic()
        run.end()
    begun = time.monotonic()
    while nodes_of(run.out) and time.monotonic() < begun + ORPHANS:
        time.sleep(0.02)
    left = (run.out / "latest").resolve()
    poses = read_run(left).log.poses
    complete(left)
    lost = at - poses[-1].sent
    orphans = nodes_of(run.out)
    return Measured(lost, f"nodes outlive it: {', '.join(orphans)}" if orphans else "")


def disk_full(folder: Path, chance: Random) -> Measured:
    """Whether a run on a full disk ends with its own exit code and a sentence, and leaves its rows."""
    with Run(folder / "runs", "--no-pictures", "--real-time", code=FULL) as run:
        code = run.end()
    rows = len(read_run(run.out / "latest").log.poses)
    wrong = {
        f"exit code {code}": code != RECORD_LOST,
        "no sentence": "cannot be written: File too large" not in run.text,
        "a traceback": "Traceback" in run.text,
        f"{rows} rows": rows < 50,
        "nodes outlive it": bool(nodes_of(run.out)),
    }
    return Measured(missed=", ".join(words for words, is_so in wrong.items() if is_so))


def nothing(bench: object) -> None:
    """The measurement does it."""


FAULTS = [
    ending(TIMEOUT),
    ending(STUCK),
    Fault("SIGKILL of bringup: time of the run not on disk", "process", LOST, nothing, in_folder(killed), long=50),
    Fault("full disk: own exit code, a sentence, rows kept", "process", None, nothing, in_folder(disk_full), long=20),
]
