"""The world that a run is shown and judged in is the one that it was in."""

from pathlib import Path

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_core.parameters.file import write_parameters
from collplan_core.worlds import save_world
from collplan_core.worlds.file import world_text
from collplan_ros.recording.description import WORLD, YAML
from collplan_ros.recording.recording_file import RECORDING, RecordingFile
from collplan_ros.runs.recorded_run import settings_and_world
from collplan_ros.runs.run_error import RunError
from made_runs import room


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    save_world(room(), tmp_path / "room.yaml")
    worlds = {"lidar.world": "slalom", "simulator.world": str(tmp_path / "room.yaml")}
    write_parameters(Settings().with_values(worlds), tmp_path / "parameters.yaml")
    return tmp_path


def recording(folder: Path) -> RecordingFile:
    file = RecordingFile(folder / RECORDING)
    file.attach(WORLD, YAML, world_text(room()))
    return file


@pytest.mark.parametrize("left", [None, "name: another\nbounds: [0, 0, 1, 1]\n"], ids=["gone", "changed"])
def test_it_is_that_of_the_recording_whatever_has_become_of_its_file(folder, left):
    recording(folder).finish()
    (folder / "room.yaml").unlink()
    if left:
        (folder / "room.yaml").write_text(left)
    _, world = settings_and_world(folder)
    assert (world.name, world.bounds) == ("room", room().bounds)
    np.testing.assert_array_equal(world.polygons[0], room().polygons[0])


def test_without_a_recording_that_can_be_read_it_is_that_of_the_simulator(folder):
    assert settings_and_world(folder)[1].name == "room"
    file = recording(folder)
    file.flush()  # and no end
    assert settings_and_world(folder)[1].name == "room"
    (folder / "room.yaml").unlink()
    with pytest.raises(RunError, match=r"parameters.yaml: simulator.world: .*room.yaml: no such file"):
        settings_and_world(folder)
    file.finish()
    assert settings_and_world(folder)[1].name == "room"
