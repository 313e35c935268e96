"""A run is read back as it was recorded, also where its recording was cut off, and whatever the clocks did."""

import errno
import os
import runpy
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer

from collplan_core.clock_steps import RunTimes, SendTimes
from collplan_core.parameters import Settings
from collplan_core.parameters.file import write_parameters
from collplan_ros.run.record import record_of
from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.run_log import RunLog
from collplan_ros.run.whole_file import RecordError, RunError, replacing
from collplan_ros.run.writer import RECORDING
from made_runs import EPOCH, GOAL, WINDOW, bouncing_run, killed_run, room, write_recording

EXAMPLES = Path(__file__).parents[2] / "examples"
HOUR = 3600.0


def assert_same(read: RunLog, log: RunLog) -> None:
    """As numbers of messages allow."""
    for name in ("poses", "truth", "sent_commands"):
        np.testing.assert_allclose(getattr(read, name), getattr(log, name), atol=1e-6, err_msg=name)
    for found, impact in zip(read.impacts, log.impacts, strict=True):
        assert (found.source, found.time) == (impact.source, pytest.approx(impact.time))
        np.testing.assert_array_equal(found.point, impact.point)
    assert record_of(read, WINDOW).commanded == record_of(log, WINDOW).commanded
    assert list(read.plans) == pytest.approx(list(log.plans))
    assert [len(contacts.times) for contacts in read.plans.values()] == [1] * 5 + [0] * 5
    assert read.goal.tolist() == GOAL.tolist()


@pytest.fixture(scope="module")
def killed(tmp_path_factory):
    return killed_run(tmp_path_factory.mktemp("runs") / "killed")


def test_a_killed_run_is_read_and_said_to_be_incomplete_and_its_folder_is_left_as_it_is(killed):
    before = {path: path.stat().st_mtime_ns for path in killed.iterdir()}
    run, log = read_run(killed), bouncing_run()
    assert_same(run.log, log)
    for contacts, expected in zip(run.log.plans.values(), log.plans.values(), strict=True):
        np.testing.assert_allclose(contacts.times, expected.times, atol=1e-6)
    assert (run.log.simulated, run.note.startswith(f"{killed}: incomplete")) == (True, True)
    assert run.end.words == "incomplete"
    np.testing.assert_allclose(run.record.speeds, record_of(log, WINDOW).speeds, atol=1e-6)
    assert {path: path.stat().st_mtime_ns for path in killed.iterdir()} == before


def rewritten(source: Path, folder: Path, marks: str, leave_out: str = "") -> Path:
    """The folder with a recording as another tool writes it: metadata `first`, `last` or `none`, alone in it."""
    folder.mkdir()
    with (source / RECORDING).open("rb") as old, (folder / RECORDING).open("wb") as new:
        reader, writer = make_reader(old), Writer(new)
        writer.start(profile="ros2", library="an editor")
        metadata = [(each.name, each.metadata) for each in reader.iter_metadata()]
        for each in metadata if marks == "first" else ():
            writer.add_metadata(*each)
        schemas, channels = dict[int, int](), dict[int, int]()
        for schema, channel, message in reader.iter_messages():
            if channel.topic == leave_out:
                continue
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
            if channel.id not in channels:
                about = channel.topic, channel.message_encoding, schemas[schema.id]
                channels[channel.id] = writer.register_channel(*about)
            writer.add_message(channels[channel.id], message.log_time, message.data, message.publish_time)
        for each in metadata if marks == "last" else ():
            writer.add_metadata(*each)
        writer.finish()
    return folder


def test_what_another_tool_has_rewritten_is_read_for_what_it_holds(tmp_path):
    (tmp_path / "own").mkdir()
    write_recording(tmp_path / "own", bouncing_run(), namespace="/robot1")
    last = bouncing_run().poses[-1]
    for marks in ("first", "last"):
        run = read_run(rewritten(tmp_path / "own", tmp_path / marks, marks))
        assert_same(run.log, bouncing_run())
        assert (run.log.simulated, run.namespace) == (True, "/robot1")
        assert list(run.lacks) == ["parameters.yaml", "world.yaml"]
        assert run.log.goals == read_run(tmp_path / "own").log.goals
    run = read_run(rewritten(tmp_path / "own", tmp_path / "none", "none"))
    assert (len(run.log.poses), run.log.poses[-1].stamp, run.namespace) == (200, last.stamp, "/robot1")
    assert "lacks parameters.yaml, world.yaml, bringup's marks of begin, goal and end; was it filtered" in run.note
    filtered = read_run(rewritten(tmp_path / "own", tmp_path / "some", "none", leave_out="/robot1/mocap/odom"))
    with pytest.raises(RunError, match=r"no poses on mocap/odom.* lacks parameters\.yaml"):
        filtered.check_poses()


def write_half(path: Path) -> None:
    with replacing(path) as new:
        new.write_text("half")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_file_takes_its_place_whole_or_not_at_all(tmp_path):
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
    worlds = {"lidar.world": "slalom", "simulator.world": str(file)}
    write_parameters(Settings().with_values(worlds), folder / "parameters.yaml")
    with pytest.raises(RunError, match=r"simulator.world: .*room.yaml: no such file"):
        read_run(folder)
    (folder / RECORDING).unlink()
    write_recording(folder, bouncing_run(), world=room())
    for left in (None, "name: another\nbounds: [0, 0, 1, 1]\n"):
        if left:
            file.write_text(left)
        world = read_run(folder).world
        assert (world.name, world.bounds) == ("room", room().bounds)
        np.testing.assert_array_equal(world.polygons[0], room().polygons[0])


# ---- clocks


@given(
    st.lists(st.tuples(st.floats(0.0, 2.0), st.sampled_from([0.0, HOUR, -HOUR, 0.5, -0.5])), min_size=1, max_size=60),
    st.floats(0.0, 0.05),
)
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
def test_the_time_of_a_run_goes_on_where_the_stamps_step(stretches):
    times, sent, ahead, before = RunTimes(), 10.0, 50.0, None
    for length, step in [*stretches, (20, 0.0)]:
        for _ in range(length):
            sent += 0.01
            time = times.of_pose(sent + ahead, sent)
            assert time == pytest.approx(sent + 50.0, abs=1e-6)
            assert before is None or time > before
            before = time
            assert times.of(sent + ahead - 0.02) == pytest.approx(time - 0.02, abs=1e-6)
        ahead += step


def test_the_script_of_examples_reads_a_run(tmp_path, monkeypatch, capsys):
    write_recording(tmp_path, bouncing_run())
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.setattr("sys.argv", ["recorded_run.py", "."])
    runpy.run_path(str(EXAMPLES / "recorded_run.py"), run_name="__main__")
    assert "poses" in capsys.readouterr().out
    assert (tmp_path / "recorded_run.png").exists()
