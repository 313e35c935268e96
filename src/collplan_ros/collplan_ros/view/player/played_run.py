"""What run.html is made from, read from a run folder."""

import json
from dataclasses import dataclass
from pathlib import Path

from collplan_core.evaluation.machine import pace_words
from collplan_core.parameters import Settings
from collplan_core.worlds import World
from collplan_ros.pictures.title import run_end, run_title
from collplan_ros.runs.impact_log import Impacts, impacts_of
from collplan_ros.runs.record_reading import RECORD, Record, read_record
from collplan_ros.runs.recorded_run import settings_and_world
from collplan_ros.runs.run_error import RunError
from collplan_ros.view import scene

INCOMPLETE = "incomplete"
SHOWN_WHOLE = 60.0
"""A shorter run is shown with all its scans, maps and sets of candidates, as far as its page has room [s]."""


@dataclass(frozen=True, eq=False)
class PlayedRun:
    """A run that can be played.

    Attributes:
        folder: the run folder.
        settings: the parameters used.
        world: the world that the robot was in.
        record: what was recorded, with at least one pose.
        impacts: its impacts.
        title: world, strategy and seed of the run, and whether it was simulated.
        end: how it ended.
        reason: why it ended so; empty where that says it all.
        machine: the part `machine` of the whole run.
    """

    folder: Path
    settings: Settings
    world: World
    record: Record
    impacts: Impacts
    title: str
    end: str
    reason: str
    machine: scene.Part

    @property
    def zero(self) -> float:
        """Time of t = 0 in the files of the run and in its page [s, poses' clock]."""
        return self.record.log.begin

    @property
    def one_in(self) -> int:
        """Of its scans, maps and sets of candidates one in so many is shown: all of a long run fill the memory."""
        return 1 + int((self.last - self.record.log.poses[0].stamp) // SHOWN_WHOLE)

    @property
    def last(self) -> float:
        """Time of the last pose [s, poses' clock]."""
        return self.record.log.poses[-1].stamp


def read_played_run(folder: Path) -> PlayedRun:
    """Reads the run in a folder of bringup, also one without results.

    Raises:
        RunError: a file is missing or has another form than bringup writes.
    """
    settings, world = settings_and_world(folder)
    record = _record(folder / RECORD)
    impacts = impacts_of(record.log, world, settings.mocap.velocity_window)
    title = run_title(world, settings, record.simulated)
    return PlayedRun(folder, settings, world, record, impacts, title, *_end(folder / "summary.json"))


def _record(path: Path) -> Record:
    if not path.exists():
        raise RunError(f"{path}: no such file, expected the record that bringup writes while a run goes on")
    try:
        record = read_record(path)
    except (OSError, LookupError, TypeError, ValueError) as error:
        raise RunError(f"{path}: expected what bringup writes: {error!r}") from None
    if not record.log.poses:
        raise RunError(f"{path}: no poses, expected those of a run")
    return record


def _end(path: Path) -> tuple[str, str, scene.Part]:
    """How the run ended, why, and the part `machine`, by its summary; without one bringup did not live to write it."""
    try:
        summary = json.loads(path.read_text())
        # summaries of earlier versions say neither why, nor anything of the machine
        machine = {"pace": pace_words(summary.get("real_time_factor")), "verdict": str(summary.get("machine", ""))}
        return run_end(summary), str(summary.get("reason", "")), machine
    except FileNotFoundError:
        return INCOMPLETE, "", {"pace": "", "verdict": ""}
    except (OSError, LookupError, TypeError, ValueError, AttributeError) as error:
        raise RunError(f"{path}: expected JSON with the figures of a run: {error!r}") from None
