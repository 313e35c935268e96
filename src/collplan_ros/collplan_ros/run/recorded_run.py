"""A run read from its folder: its parameters, its world and its log, also of one whose bringup was killed."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from mcap.records import Metadata

import collplan_core.planners  # noqa: F401  (registers what a run may have been planned by)
from collplan_core.evaluation.run_end import pace_words
from collplan_core.evaluation.run_record import RunRecord
from collplan_core.parameters import Settings, Simulation
from collplan_core.parameters.file import parameters_of, read_parameters
from collplan_core.parameters.spec import ParameterError
from collplan_core.replay.journal import PLANNER
from collplan_core.replay.reading import Beginning, events_of, rows_of
from collplan_core.replay.values import JournalError
from collplan_core.worlds import UNKNOWN, World, WorldError, load_world
from collplan_core.worlds.file import parse_text
from collplan_ros.run.description import BEGIN, CLOCK, END, GOAL, PARAMETERS, RUN, WORLD
from collplan_ros.run.reader import attachment, description, entries, is_whole, messages, namespace_of
from collplan_ros.run.record import counted_impacts, record_of
from collplan_ros.run.run_log import End, LogBuilder, RunLog, SentPoint
from collplan_ros.run.whole_file import RunError, has_end
from collplan_ros.run.writer import RECORDING

NANO = 10**9
SUMMARY, INCOMPLETE = "summary.json", "incomplete"
LONGEST = 120
"""Characters of a world's name that are shown."""


class RunEnd(NamedTuple):
    """End of a run in words, its reason where they do not suffice, and the speed of simulated time and the machine."""

    words: str
    reason: str = ""
    pace: str = ""
    machine: str = ""


@dataclass(frozen=True, eq=False)
class RecordedRun:
    """A run read from its folder, which all that shows or tells of it is made from."""

    folder: Path
    settings: Settings
    world: World
    log: RunLog
    clock_ahead: int  # of the recording's clock before that of `sent` in the log [ns]
    namespace: str
    has_results: bool  # whether bringup, or its completion, has written them
    is_whole: bool  # whether its recording has an end
    has_ended: bool  # whether the recording says that the run did
    lacks: Sequence[str] = ()  # what bringup puts into a recording and is not in this one, in words

    @cached_property
    def record(self) -> RunRecord:
        """What came of it."""
        return record_of(self.log, self.settings.mocap.velocity_window)

    @property
    def title(self) -> str:
        """World, strategy and seed, and whether it was simulated, on one line."""
        # a world's name may be any text: both ends of it tell more than its beginning
        name = " ".join(self.world.name.split())
        if len(name) > LONGEST:
            name = f"{name[: LONGEST // 2]}...{name[3 - LONGEST // 2 :]}"
        kind = "simulated" if self.log.simulated else "measured"
        return f"{name}, {self.settings.planner.strategy}, seed {self.settings.simulator.seed} ({kind})"

    @property
    def end(self) -> RunEnd:
        """Its end as summary.json tells it, INCOMPLETE without one; RunError: it has another form than bringup's."""
        path = self.folder / SUMMARY
        try:
            summary = json.loads(path.read_text())
            arrival = summary["arrival_time_s"]
            end = f"goal reached in {arrival:.1f} s" if arrival is not None else summary["outcome"].replace("_", " ")
            words = f"{end}, {summary['path_length_m']:.2f} m, {counted_impacts(summary['impacts'])}"
            pace = pace_words(summary.get("real_time_factor"))
            return RunEnd(words, str(summary.get("reason", "")), pace, str(summary.get("machine", "")))
        except FileNotFoundError:
            return RunEnd(INCOMPLETE)
        except (OSError, LookupError, TypeError, ValueError, AttributeError) as error:
            raise RunError(f"{path}: expected JSON with the figures of a run: {error!r}") from None

    @property
    def recording(self) -> Path:
        """The file that holds all that was recorded."""
        return self.folder / RECORDING

    def check_poses(self) -> None:
        """Raises RunError where there is no pose."""
        if not self.log.poses:
            lacking = f": it lacks {', '.join(self.lacks)}; was it filtered?" if self.lacks else ""
            raise RunError(f"{self.recording}: no poses on mocap/odom, expected those of a run{lacking}")

    @property
    def note(self) -> str:
        """A sentence for the user where the run is not there to its end; "" where it is."""
        if self.lacks:
            return f"{self.recording}: lacks {', '.join(self.lacks)}; was it filtered, or rewritten by another tool?"
        if (self.has_results or self.has_ended) and self.is_whole:
            return ""
        poses = self.log.poses
        held = f"holds it up to {poses[-1].stamp - self.log.begin:.2f} s" if poses else "holds no pose"
        why = "bringup ended before the run did" if self.is_whole else "its recording is cut off"
        return f"{self.folder}: incomplete, {why}; {RECORDING} {held}"


def read_run(folder: Path) -> RecordedRun:
    """Reads the run in a folder of bringup; RunError: a file is missing or has another form than bringup writes."""
    if not folder.is_dir():
        raise RunError(f"{folder}: not a folder, expected one that bringup left")
    path = folder / RECORDING
    lacks: list[str] = []
    settings = _settings(folder / PARAMETERS, path, lacks)
    world = _world(path, settings.simulator, lacks)
    namespace, clock_ahead = namespace_of(path), int(description(path, RUN).get(CLOCK, "0"))
    builder = LogBuilder(settings)
    marks, placed = _marks(path, clock_ahead, lacks)
    for entry in entries(path, builder.topics):
        if isinstance(entry, Metadata):
            if placed:
                take_mark(builder, entry.name, entry.metadata)
            continue
        sent = (entry.sent - clock_ahead) / NANO
        while not placed and marks and marks[0][0] <= sent:
            take_mark(builder, *marks.pop(0)[1:])
        if (message := entry.content) is not None:
            builder.take(entry.topic, message, sent)
    for _, name, values in [] if placed else marks:
        take_mark(builder, name, values)
    whole = has_end(folder / SUMMARY), is_whole(path), any(name == END for _, name, _ in marks)
    return RecordedRun(folder, settings, world, builder.log, clock_ahead, namespace, *whole, lacks)


Mark = tuple[float, str, dict[str, str]]
"""Time from which a mark holds [s], its name and its values."""


def _marks(path: Path, clock_ahead: int, lacks: list[str]) -> tuple[list[Mark], bool]:
    """The marks of a recording, and whether they are between its messages, where bringup has put them."""
    found, between = list[Metadata](), False
    goals, truth = list[Mark](), False
    for entry in entries(path, ("mocap/odom", "goal_pose", "ground_truth/odom")):
        if isinstance(entry, Metadata):
            found += [entry] if entry.name in (BEGIN, GOAL, END) else []
        elif entry.topic == "goal_pose":
            if (asked := entry.content) is not None:
                sent, at = (entry.sent - clock_ahead) / NANO, asked.pose.position
                values = dict(zip(SentPoint._fields, map(str, (sent, at.x, at.y)), strict=True))
                repeated = goals and goals[-1][2] | {"sent": ""} == values | {"sent": ""}
                goals += [] if repeated else [(sent, GOAL, values)]
        else:
            between |= bool(found) and found[-1].name != END
            truth |= entry.topic == "ground_truth/odom"
    if not found and not is_whole(path):
        return [], True  # cut off before the run began
    if not found:  # lost: a run is what was recorded, to the goals published
        lacks.append("bringup's marks of begin, goal and end")
        return [(-math.inf, BEGIN, {"simulated": str(truth).lower()}), *goals], False
    timed = [(_time_of(found[k:]), each.name, each.metadata) for k, each in enumerate(found)]
    return timed, between


def _time_of(marks: Sequence[Metadata]) -> float:
    """Time [s] from which the first of these holds if another tool has moved them: its goal's; the end's comes last."""
    if marks[0].name == END:
        return math.inf
    return next((float(each.metadata["sent"]) for each in marks if each.name == GOAL), -math.inf)


def take_mark(builder: LogBuilder, name: str, values: Mapping[str, str]) -> None:
    """Gives a builder a mark between the messages: begin, goals and end of the run."""
    if name == BEGIN:
        builder.begin(values["simulated"] == "true")
    elif name == GOAL:
        builder.asked(SentPoint(*(float(values[key]) for key in SentPoint._fields)))
    elif name == END:
        builder.end(End(*(float(values[key]) for key in End._fields)))


def _settings(path: Path, recording: Path, lacks: list[str]) -> Settings:
    """Returns the parameters in the recording, in their file, which may be cut off, or in its journal."""
    try:
        try:
            return Settings().with_values(
                parameters_of(attachment(recording, PARAMETERS), f"{recording}: {PARAMETERS}")
            )
        except RunError:  # none are attached
            if path.exists():
                return Settings().with_values(read_parameters(path))
        lacks.append(PARAMETERS)
        lines = (each.data for _, _, each in messages(recording, ["planner/journal"]))
        begun = (each for each in events_of(rows_of(lines, str(recording)), PLANNER) if isinstance(each, Beginning))
        return next((each.settings for each in begun), Settings().with_values({"simulator.world": UNKNOWN}))
    except (JournalError, ParameterError) as error:  # names the file
        raise RunError(str(error)) from None


def _world(path: Path, simulator: Simulation, lacks: list[str]) -> World:
    """Returns the world in the recording, whether or not its file still exists."""
    try:
        try:
            return parse_text(attachment(path, WORLD), f"{path}: {WORLD}", simulator.world)
        except RunError:  # none is attached
            lacks += [WORLD] if lacks or simulator.world == UNKNOWN else []
            return load_world(simulator.world)
    except (WorldError, OSError) as error:
        raise RunError(f"{path}: simulator.world: {error}") from None
