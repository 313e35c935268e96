"""The record of a run on disk: read back as it was written, also cut off anywhere, and what a full disk does to it."""

import errno
import os
import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from collplan_ros.run.record_reading import RECORD, read_record
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.parameters import Settings
from collplan_core.parameters.file import write_parameters
from collplan_core.worlds import save_world
from collplan_core.worlds.file import world_text
from collplan_ros.run.description import WORLD, YAML
from collplan_ros.run.impacts import impacts_of
from collplan_ros.run.page.played_run import read_played_run
from collplan_ros.run.recorded_run import read_run, settings_and_world
from collplan_ros.run.run_error import RecordError, RecordFile, RunError
from collplan_ros.run.run_times import RunTimes, continued
from collplan_ros.run.send_times import SendTimes
from collplan_ros.run.whole_file import replacing
from collplan_ros.run.writer import RECORDING, RecordingFile
from made_runs import AHEAD, EPOCH, GOAL, WINDOW, bouncing_run, room, write_record

HOUR = 3600.0


def test_what_was_written_is_read(tmp_path):
    log = bouncing_run()
    odd = np.concatenate([[np.inf, np.nan], log.scans[3].ranges[2:]])
    log.scans[3] = replace(log.scans[3], ranges=odd)
    write_record(tmp_path / RECORD, log)
    read = read_record(tmp_path / RECORD)
    assert (read.simulated, read.goal.tolist()) == (True, GOAL.tolist())
    assert read.log.poses == log.poses
    assert read.log.commands == log.commands
    assert read.log.true_impacts == log.true_impacts
    assert [s.stamp for s in read.log.scans] == [s.stamp for s in log.scans]
    np.testing.assert_array_equal(read.log.scans[3].ranges, log.scans[3].ranges)
    np.testing.assert_allclose(read.log.plans[2].times, log.plans[2].times, atol=1e-6)
    unpictured = read_record(tmp_path / RECORD, pictured=False).log
    assert (unpictured.scans, unpictured.plans, unpictured.poses) == ([], [], log.poses)
    assert read.wall_clock == [(-np.inf, AHEAD)]


@pytest.fixture(scope="module")
def killed(tmp_path_factory):
    """The folder of a run whose bringup was killed: parameters, and a record that was cut off in a line."""
    folder = tmp_path_factory.mktemp("killed")
    save_world(room(), folder / "room.yaml")
    worlds = {key: str(folder / "room.yaml") for key in ("lidar.world", "simulator.world")}
    write_parameters(Settings().with_values(worlds), folder / "parameters.yaml")
    write_record(folder / RECORD, bouncing_run())
    with (folder / RECORD).open("a") as file:
        file.write('["pose",1700000002.0,0.1')
    return folder


def test_a_killed_run_is_read_as_far_as_it_is_recorded_and_said_to_be_incomplete(killed):
    run, log = read_run(killed), bouncing_run()
    assert run.simulated
    assert len(run.path.times) == len(log.poses)
    np.testing.assert_allclose(run.path.points[:, 0], [row.x for row in log.poses], atol=1e-6)
    assert run.note.startswith(f"{killed}: incomplete")
    assert "1.84 s" in run.note
    played, impacts = read_played_run(killed), impacts_of(log, room(), WINDOW)
    assert played.end == "incomplete"
    np.testing.assert_allclose(played.impacts.times, impacts.times, atol=1e-6)
    assert played.impacts.deliberate.tolist() == impacts.deliberate.tolist()


@given(st.integers(0, 4000))
@settings(derandomize=True, deadline=None, max_examples=30)
def test_a_record_cut_off_anywhere_holds_what_came_before(cut):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / RECORD
        file = RecordFile(path)
        for k in range(50):
            file.write("pose", EPOCH + k, 0.0, 0.0, 0.0, 0.0, 0.0, 77.0 + k)
        file.flush()
        text = path.read_bytes()[:cut]
        path.write_bytes(text)
        read = read_record(path).log.poses
        assert text.count(b"\n") <= len(read) <= text.count(b"\n") + 1


def write_half(path: Path) -> None:
    with replacing(path) as new:
        new.write_text("half")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_full_disk_is_said_once_and_a_file_takes_its_place_whole_or_not_at_all(tmp_path):
    file = RecordFile(Path("/dev/full"))
    file.write("asked", 1.0)
    with pytest.raises(RecordError, match=r"^/dev/full: cannot be written: No space left"):
        file.flush()
    file.write("asked", 2.0)
    file.flush()
    path = tmp_path / "summary.json"
    path.write_text("old")
    with pytest.raises(RecordError, match=r"summary.json: cannot be written: No space left"):
        write_half(path)
    assert path.read_text() == "old"
    with replacing(path) as new:
        new.write_text("new")
    assert path.read_text() == "new"
    assert [entry.name for entry in tmp_path.iterdir()] == ["summary.json"]


# ---- the world that a run is shown and judged in is the one that it was in


def test_the_world_is_that_of_the_recording_whatever_has_become_of_its_file(killed, tmp_path):
    folder, file = shutil.copytree(killed, tmp_path / "run"), tmp_path / "room.yaml"
    save_world(room(), file)
    worlds = {"lidar.world": "slalom", "simulator.world": str(file)}
    write_parameters(Settings().with_values(worlds), folder / "parameters.yaml")
    assert settings_and_world(folder)[1].name == "room"
    recording = RecordingFile(folder / RECORDING)
    recording.attach(WORLD, YAML, world_text(room()))
    recording.flush()  # and no end
    assert settings_and_world(folder)[1].name == "room"
    file.unlink()
    with pytest.raises(RunError, match=r"parameters.yaml: simulator.world: .*room.yaml: no such file"):
        settings_and_world(folder)
    recording.finish()
    for left in (None, "name: another\nbounds: [0, 0, 1, 1]\n"):
        if left:
            file.write_text(left)
        _, world = settings_and_world(folder)
        assert (world.name, world.bounds) == ("room", room().bounds)
        np.testing.assert_array_equal(world.polygons[0], room().polygons[0])


# ---- clocks


@given(
    st.lists(st.tuples(st.floats(0.0, 2.0), st.sampled_from([0.0, HOUR, -HOUR, 0.5, -0.5])), min_size=1, max_size=60),
    st.floats(0.0, 0.05),
)
@settings(derandomize=True, deadline=None, max_examples=30)
def test_times_of_sending_rise_evenly_however_the_wall_clock_is_set(steps, delay):
    clock = {"steady": 100.0, "ahead": EPOCH}
    times = SendTimes(lambda: clock["steady"] + clock["ahead"], lambda: clock["steady"])
    for pause, step in steps:
        clock["steady"] += pause
        sent, stamp = clock["steady"], clock["steady"] + clock["ahead"]
        clock["ahead"] += step if abs(step) > 1.0 else 0.0  # set while the message is on its way
        clock["steady"] += delay
        assert times.steady(stamp) == pytest.approx(sent, abs=1e-5)


@given(st.lists(st.tuples(st.integers(1, 40), st.sampled_from([HOUR, -HOUR, 60.0, -1.0])), max_size=5))
@settings(derandomize=True, deadline=None, max_examples=30)
def test_the_time_of_a_run_goes_on_where_the_stamps_step(stretches):
    times, sent, ahead, before = RunTimes(), 10.0, 50.0, None
    for length, step in [*stretches, (20, 0.0)]:
        for _ in range(length):
            sent += 0.01
            time = times.of_pose(sent + ahead, sent)
            assert time == pytest.approx(sent + 50.0, abs=1e-6)
            assert before is None or time > before
            before = time
            assert continued(sent + ahead - 0.02, time, times.corrections) == pytest.approx(time - 0.02, abs=1e-6)
        ahead += step
