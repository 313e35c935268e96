"""Description of a run in its recording, beside the messages: parameters, world, robot, goal, and the code used."""

import platform
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from collplan_core.jit import sources_digest
from collplan_core.worlds import World, world_text
from collplan_ros.run.writer import RecordingFile

PARAMETERS, WORLD = "parameters.yaml", "world.yaml"
"""Names of the attachments."""
RUN, VERSION = "run", "version"
"""Names of the descriptions of the whole run: the request, and the code."""
BEGIN, GOAL, END = "begin", "goal", "end"
"""Names of the marks between the messages: the run begins, a goal is given, the run ends."""
CLOCK = "clock_ahead_ns"
"""Time by which the clock of a recording's times is ahead of that of `sent` [ns]."""
YAML = "application/yaml"
PACKAGES = ("collplan-core", "collplan-ros", "omnipuck-sim", "omnipuck-driver", "numpy", "scipy", "numba", "shapely")


def describe_run(
    recording: RecordingFile,
    parameters: Path,
    world: World,
    goal: Sequence[float],
    simulated: bool,
    namespace: str,
    clock_ahead: int,
) -> None:
    """Begins a recording, to which nothing was written yet, with the description of its run.

    `parameters` is the file of all parameters, the goal x, y [m]; the clock of the messages' times is `clock_ahead` of
    the steady clock [ns]. OSError: the file of parameters cannot be read. RecordError: the recording cannot be written.
    """
    recording.attach(PARAMETERS, YAML, parameters.read_text(encoding="utf-8"))
    recording.attach(WORLD, YAML, world_text(world))
    about = {"goal": " ".join(map(str, goal)), "simulated": str(simulated).lower(), "namespace": namespace}
    about[CLOCK] = str(clock_ahead)
    recording.describe(RUN, about)
    recording.describe(VERSION, versions())
    recording.flush()


def versions() -> dict[str, str]:
    """The code: versions of packages and Python, kind of the machine, and a hash over the sources of the algorithm."""
    found = {name: _version(name) for name in PACKAGES}
    known = {name: value for name, value in found.items() if value}
    return {**known, "python": platform.python_version(), "machine": platform.machine(), "sources": sources_digest()}


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""
