"""The world that a run was in, whatever has become of its file since."""

from pathlib import Path

from collplan_core.parameters import Settings
from collplan_core.worlds import World, load_world
from collplan_core.worlds.file import parse_text
from collplan_ros.recording.description import WORLD
from collplan_ros.recording.reading import attachment
from collplan_ros.recording.recording_file import RECORDING
from collplan_ros.runs.run_error import RunError


def recorded_world(folder: Path, settings: Settings) -> World:
    """The world of the run in a folder: as its recording holds it, else what simulator.world names today.

    Raises:
        WorldError: there is no such world.
    """
    try:
        text = attachment(folder / RECORDING, WORLD)
    except RunError:  # no recording, or none that can be read
        return load_world(settings.simulator.world)
    return parse_text(text, f"{folder / RECORDING}: {WORLD}", settings.simulator.world)
