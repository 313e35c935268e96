"""Run folders made by hand that can be played, and what is in the page of one."""

import base64
import gzip
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from collplan_core.parameters import Settings
from collplan_core.parameters.file import write_parameters
from collplan_ros.run.run_log import RunLog
from made_runs import Said, bouncing_run, write_recording

ROOM = {
    "bounds": [-2.0, -1.5, 2.5, 1.5],
    "polygons": [[[1, -1], [2, -1], [2, 1], [1, 1]]],
    "circles": [{"center": [-1.0, 0.5], "radius": 0.2}],
}


def status(name: str, level: bytes, message: str, **values: str) -> DiagnosticStatus:
    pairs = [KeyValue(key=key, value=value) for key, value in values.items()]
    return DiagnosticStatus(name=name, level=level, message=message, values=pairs)


COSTS = status(
    "planner", b"\0", "", planning_time_ms="3.25", candidates="80", hardest_contact="0.4", strategy="harness"
)
SAID: tuple[Said, ...] = (
    (77.02, "goal_status", GoalStatus(status=GoalStatus.STATUS_ACCEPTED)),
    (77.2, "planner/costs", DiagnosticArray(status=[COSTS])),
    (77.3, "goal_status", GoalStatus(status=GoalStatus.STATUS_EXECUTING)),
    (77.4, "robot/state", status("/simulator_node", b"\1", "its node has started", state="held")),
    (78.99, "goal_status", GoalStatus(status=GoalStatus.STATUS_SUCCEEDED)),
)


def played_folder(
    parent: Path,
    log: RunLog | None = None,
    name: str = "room",
    strategy: str = "harness",
    said: Sequence[Said] = SAID,
    run: str = "run",
    namespace: str = "",
) -> Path:
    """The folder of a run that bringup has finished, in a world of this name."""
    folder = parent / run
    folder.mkdir(parents=True)
    world = parent / "room.yaml"
    world.write_text(yaml.safe_dump({"name": name, **ROOM}))
    values = {"lidar.world": str(world), "simulator.world": str(world), "planner.strategy": strategy}
    write_parameters(Settings().with_values(values), folder / "parameters.yaml")
    write_recording(folder, log or bouncing_run(), said=said, namespace=namespace)
    summary = {"arrival_time_s": 1.84, "outcome": "reached", "path_length_m": 0.72, "impacts": 1}
    (folder / "summary.json").write_text(json.dumps(summary))
    return folder


def recordings_in(page: str) -> list[dict[str, Any]]:
    packed = re.findall(r'<script type="application/gzip" class="recording">([A-Za-z0-9+/=]*)</script>', page)
    return [json.loads(gzip.decompress(base64.b64decode(each))) for each in packed]


def recording_in(page: str) -> dict[str, Any]:
    (recording,) = recordings_in(page)
    return recording


def poses_in(frames: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """(n, 3) time [ms] and place [mm] of every pose in the frames, in order."""
    rows: list[list[float]] = []
    for frame in frames:
        trail = np.array(frame.get("trail", [])).reshape(-1, 3)
        rows += [[1e3 * frame["t"] - before, x, y] for before, x, y in trail.tolist()]
        rows.append([1e3 * frame["t"], *frame["robot"][:2]])
    return np.array(rows)


def newest(frames: Sequence[Mapping[str, Any]], part: str, time: float) -> Any:
    """What the page shows of a part at a time [s]."""
    return next(frame[part] for frame in reversed(frames) if frame["t"] <= time and part in frame)
