"""bringup as a process, and the processes that it leaves."""

import json
import subprocess
import sys
import time
from pathlib import Path

from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.writer import RECORDING

PATIENCE = 100.0
SLOWLY = ("--max-speed", "0.3", "--no-pictures", "--real-time")
"""Options of a run that a test ends: it does not reach its goal before a busy machine has looked at it."""
IN_PROCESSES = (*SLOWLY, "--processes")
"""The same with a process for each node."""
NODES = {"simulator_node", "mocap_node", "lidar_node", "planner_node", "controller_node"}


def nodes_of(out: Path) -> dict[str, int]:
    """Name and pid of each living node that was given the parameters of a run under `out`."""
    found = {}
    for entry in Path("/proc").iterdir():
        try:
            arguments = (entry / "cmdline").read_bytes().decode().split("\0") if entry.name.isdigit() else []
            state = (entry / "stat").read_text().rpartition(")")[2].split()[0] if arguments else "Z"
        except (OSError, UnicodeDecodeError):
            continue
        if state != "Z" and any(argument.startswith(f"{out.resolve()}/") for argument in arguments):
            found[next(Path(a).name for a in arguments if Path(a).name in {*NODES, "view_node", "base_node"})] = int(
                entry.name
            )
    return found


def wait_for(condition):
    deadline = time.monotonic() + PATIENCE
    while not (value := condition()):
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.02)
    return value


class Run:
    """A bringup process that cannot outlive its test."""

    def __init__(self, out: Path, *options: str) -> None:
        self.out = out
        self.output = out.with_suffix(".txt")
        command = [sys.executable, "-m", "collplan_ros.bringup.main", "--out", str(out), *options]
        self.process = subprocess.Popen(command, stdout=self.output.open("wb"), stderr=subprocess.STDOUT)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()

    @property
    def text(self) -> str:
        return self.output.read_text()

    def moving(self) -> bool:
        assert self.process.poll() is None, self.text
        return "free_space" in self.text or "boundary_following" in self.text

    def has_recorded(self) -> bool:
        """Whether a pose of the run is on disk."""
        recording = self.out / "latest" / RECORDING
        if not recording.exists() or not recording.stat().st_size:
            return False
        return bool(read_run(recording.parent).log.poses)

    def end(self) -> int:
        return self.process.wait(PATIENCE)

    def summary(self) -> dict:
        return json.loads((self.out / "latest" / "summary.json").read_text())
