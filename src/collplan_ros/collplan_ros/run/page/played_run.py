"""Run that run.html is made from."""

import json
from dataclasses import dataclass
from pathlib import Path

from collplan_core.evaluation.run_end import pace_words
from collplan_ros.run.impacts import JudgedImpacts, impacts_of
from collplan_ros.run.picture import run_end, run_title
from collplan_ros.run.recorded_run import RecordedRun
from collplan_ros.run.whole_file import RunError
from collplan_ros.view import scene

INCOMPLETE = "incomplete"
SHOWN_WHOLE = 60.0
"""A shorter run is shown with all its scans, maps and sets of candidates, as far as its page has room [s]."""


@dataclass(frozen=True, eq=False)
class PlayedRun:
    """A run that can be played.

    Attributes:
        run: the run.
        impacts: its impacts.
        title: world, strategy and seed of the run, and whether it was simulated.
        end: its end, in words.
        reason: reason of its end; empty where the end suffices.
        machine: the part `machine` of the whole run.
    """

    run: RecordedRun
    impacts: JudgedImpacts
    title: str
    end: str
    reason: str
    machine: scene.Part

    @property
    def zero(self) -> float:
        """Time of t = 0 in the files of the run and in its page [s, poses' clock]."""
        return self.run.log.begin

    @property
    def decimation(self) -> int:
        """Decimation factor of scans, maps and sets of candidates: all those of a long run fill the memory."""
        return 1 + int(self.duration // SHOWN_WHOLE)

    @property
    def duration(self) -> float:
        """Time from the first to the last pose [s]."""
        poses = self.run.log.poses
        return poses[-1].stamp - poses[0].stamp


def played(run: RecordedRun) -> PlayedRun:
    """Returns a run that was read, with its results.

    Raises:
        RunError: it has no poses, or summary.json has another form than bringup writes.
    """
    run.check_poses()
    impacts = impacts_of(run.log, run.settings.mocap.velocity_window)
    title = run_title(run.world, run.settings, run.log.simulated)
    return PlayedRun(run, impacts, title, *_end(run.folder / "summary.json"))


def _end(path: Path) -> tuple[str, str, scene.Part]:
    """Returns the run's end, its reason and the part `machine`; INCOMPLETE where bringup wrote no summary."""
    try:
        summary = json.loads(path.read_text())
        machine = {"pace": pace_words(summary.get("real_time_factor")), "verdict": str(summary.get("machine", ""))}
        return run_end(summary), str(summary.get("reason", "")), machine
    except FileNotFoundError:
        return INCOMPLETE, "", {"pace": "", "verdict": ""}
    except (OSError, LookupError, TypeError, ValueError, AttributeError) as error:
        raise RunError(f"{path}: expected JSON with the figures of a run: {error!r}") from None
