"""A run read from its folder: its parameters, its world and its log, also of one whose bringup was killed."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Metadata

import collplan_core.planners  # noqa: F401  (registers what a run may have been planned by)
from collplan_core.parameters import Settings, Simulation
from collplan_core.parameters.file import parameters_of, read_parameters
from collplan_core.parameters.spec import ParameterError
from collplan_core.worlds import World, WorldError, load_world
from collplan_core.worlds.file import parse_text
from collplan_ros.run.description import BEGIN, CLOCK, END, GOAL, PARAMETERS, RUN, WORLD
from collplan_ros.run.log_builder import End, LogBuilder
from collplan_ros.run.reader import attachment, content, description, entries, is_whole
from collplan_ros.run.run_log import RunLog, SentGoal
from collplan_ros.run.whole_file import RunError, has_end
from collplan_ros.run.writer import RECORDING

NANO = 10**9


@dataclass(frozen=True, eq=False)
class RecordedRun:
    """A run read from its folder.

    Attributes:
        folder: the run folder.
        settings: the parameters used.
        world: the world that the robot was in.
        log: log of the run.
        clock_ahead: time by which the clock of the recording is ahead of that of `sent` in the log [ns].
        namespace: namespace of the robot's nodes.
        has_results: whether bringup, or its completion, has written the run's results.
        is_whole: whether its recording has an end.
    """

    folder: Path
    settings: Settings
    world: World
    log: RunLog
    clock_ahead: int
    namespace: str
    has_results: bool
    is_whole: bool

    @property
    def recording(self) -> Path:
        """The file that holds all that was recorded."""
        return self.folder / RECORDING

    def check_poses(self) -> None:
        """Raises RunError where there is no pose."""
        if not self.log.poses:
            raise RunError(f"{self.recording}: no poses, expected those of a run")

    @property
    def note(self) -> str:
        """A sentence for the user where the run is not there to its end; "" where it is."""
        if self.has_results and self.is_whole:
            return ""
        poses = self.log.poses
        held = f"holds it up to {poses[-1].stamp - self.log.begin:.2f} s" if poses else "holds no pose"
        why = "bringup ended before the run did" if self.is_whole else "its recording is cut off"
        return f"{self.folder}: incomplete, {why}; {RECORDING} {held}"


def read_run(folder: Path) -> RecordedRun:
    """Reads the run in a folder of bringup.

    Raises:
        RunError: a file is missing or has another form than bringup writes.
    """
    if not folder.is_dir():
        raise RunError(f"{folder}: not a folder, expected one that bringup left")
    path = folder / RECORDING
    settings = _settings(folder / PARAMETERS, path)
    about = description(path, RUN)
    namespace, clock_ahead = about.get("namespace", "/"), int(about.get(CLOCK, "0"))
    builder = LogBuilder(settings)
    for entry in entries(path, builder.topics):
        if isinstance(entry, Metadata):
            take_mark(builder, entry.name, entry.metadata)
            continue
        if (message := content(entry)) is not None:
            builder.take(entry.topic, message, (entry.sent - clock_ahead) / NANO)
    whole = has_end(folder / "summary.json"), is_whole(path)
    return RecordedRun(folder, settings, _world(path, settings.simulator), builder.log, clock_ahead, namespace, *whole)


def take_mark(builder: LogBuilder, name: str, values: Mapping[str, str]) -> None:
    """Gives a builder a mark between the messages: begin, goals and end of the run."""
    if name == BEGIN:
        builder.begin(values["simulated"] == "true")
    elif name == GOAL:
        builder.ask(SentGoal(*(float(values[key]) for key in SentGoal._fields)))
    elif name == END:
        builder.end(End(*(float(values[key]) for key in End._fields)))


def _settings(path: Path, recording: Path) -> Settings:
    """Returns the parameters in the recording, or where there are none those in their file, which may be cut off."""
    try:
        try:
            return Settings().with_values(
                parameters_of(attachment(recording, PARAMETERS), f"{recording}: {PARAMETERS}")
            )
        except RunError:  # none are attached
            return Settings().with_values(read_parameters(path))
    except ParameterError as error:  # names the file
        raise RunError(str(error)) from None


def _world(path: Path, simulator: Simulation) -> World:
    """Returns the world in the recording, whether or not its file still exists."""
    try:
        try:
            return parse_text(attachment(path, WORLD), f"{path}: {WORLD}", simulator.world)
        except RunError:  # none is attached
            return load_world(simulator.world)
    except (WorldError, OSError) as error:
        raise RunError(f"{path}: simulator.world: {error}") from None
