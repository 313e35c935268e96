"""A recording whose bringup was killed is completed: what was closed of it is there, wherever it was cut off."""

import json
import tempfile
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.highlevel import AnyReader

from collplan_core.parameters import Settings
from collplan_core.parameters.file import write_parameters
from collplan_core.worlds import save_world
from collplan_ros.replay.main import main
from collplan_ros.run.completion import KILLED, complete, complete_newest
from collplan_ros.run.reader import attachment, raw_messages
from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.result_files import SUMMARY
from collplan_ros.run.whole_file import FolderLock, RunError
from collplan_ros.run.writer import LIBRARY, RECORDING
from made_recordings import TOPICS, MadeRecording, String, point
from made_runs import bouncing_run, room, write_recording

CHUNKS, IN_CHUNK = 6, 5
HEADER = 8 + 9 + len("....ros2....") + len(LIBRARY)
"""Where the first record ends [bytes]."""
BEING_WRITTEN = "is being written"


def unfinished(path: Path) -> tuple[list[tuple[str, int, bytes]], list[int], bytes]:
    """The rows of a recording without end, the size of its file after each chunk, and its content."""
    made, sizes = MadeRecording(path), []
    for number in range(CHUNKS * IN_CHUNK):
        topic = "/controller/reference" if number % 3 else "/maneuver"
        made.write(topic, point(float(number), 0.5) if number % 3 else String(f"maneuver {number}"))
        if number % IN_CHUNK == IN_CHUNK - 1:
            made.file.flush()
            sizes.append(path.stat().st_size)
    content = path.read_bytes()
    made.file.finish()
    return made.rows, sizes, content


def rows_of(path: Path) -> list[tuple[str, int, bytes]]:
    return [(each.topic, each.came, each.data) for each in raw_messages(path, list(TOPICS))]


with tempfile.TemporaryDirectory() as _folder:
    ROWS, SIZES, WHOLE = unfinished(Path(_folder) / RECORDING)


def completed(content: bytes) -> tuple[str, list[tuple[str, int, bytes]]]:
    """What is said of a recording with this content, and the rows that both libraries find in it afterwards."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / RECORDING
        path.write_bytes(content)
        said = complete(Path(folder))
        rows = rows_of(path)
        if rows:
            with AnyReader([path]) as reader:
                assert [(c.topic, came, data) for c, came, data in reader.messages()] == rows
        assert [entry.name for entry in Path(folder).iterdir()] == [RECORDING]
        return said, rows


@given(st.integers(HEADER, len(WHOLE)))
@settings(derandomize=True, deadline=None, max_examples=50)
def test_a_recording_cut_off_anywhere_holds_every_chunk_that_was_closed(cut):
    said, rows = completed(WHOLE[:cut])
    assert rows == ROWS[: len(rows)]
    assert len(rows) >= IN_CHUNK * sum(size <= cut for size in SIZES)
    assert len(rows) % IN_CHUNK == 0
    assert f"{len(rows)} messages" in said


def test_a_recording_cut_off_in_its_end_holds_everything(tmp_path):
    made = MadeRecording(tmp_path / RECORDING)
    for number in range(10):
        made.write("/controller/reference", point(float(number), 0.0))
    made.file.finish()
    content = made.path.read_bytes()
    for at in (-1, *range(-45, 0, 4)):
        made.path.write_bytes(content[:at])
        assert "10 messages" in complete(tmp_path)
        assert rows_of(made.path) == made.rows
        assert attachment(made.path, "parameters.yaml") == "/**: {}\n"


@given(st.integers(HEADER, len(WHOLE) - 1), st.integers(1, 255))
@settings(derandomize=True, deadline=None, max_examples=50)
def test_what_a_broken_disk_has_changed_is_left_out_and_nothing_is_made_up(at, change):
    changed = bytearray(WHOLE)
    changed[at] ^= change
    assert set(completed(bytes(changed))[1]) <= set(ROWS)


def test_a_chunk_that_cannot_be_read_costs_no_other():
    changed = bytearray(WHOLE)
    changed[SIZES[1] + 60] ^= 0xFF
    assert completed(bytes(changed))[1] == [*ROWS[: 2 * IN_CHUNK], *ROWS[3 * IN_CHUNK :]]


def test_what_begins_as_no_recording_is_left_as_it_is(tmp_path):
    for content in (WHOLE[: HEADER - 1], WHOLE[:8], b"\0" + WHOLE[1:], b"t,x,y\n"):
        (tmp_path / RECORDING).write_bytes(content)
        with pytest.raises(RunError, match=f"{tmp_path / RECORDING}: does not begin like a recording"):
            complete(tmp_path)
        assert (tmp_path / RECORDING).read_bytes() == content


def test_a_recording_that_is_whole_is_left_alone(tmp_path):
    path = tmp_path / RECORDING
    made = MadeRecording(path)
    made.write("/controller/reference", point(1.0, 2.0))
    made.file.finish()
    whole, written = path.read_bytes(), path.stat()
    with pytest.raises(RunError, match="cannot be made"):
        complete(tmp_path)
    assert path.read_bytes() == whole
    assert path.stat().st_ino == written.st_ino


# ---- the run folder, and the next bringup


def killed_run(folder: Path) -> Path:
    folder.mkdir(parents=True)
    save_world(room(), folder / "room.yaml")
    worlds = {key: str(folder / "room.yaml") for key in ("lidar.world", "simulator.world")}
    write_parameters(Settings().with_values(worlds), folder / "parameters.yaml")
    write_recording(folder, bouncing_run(), finished=False)
    return folder


def test_the_files_of_a_killed_run_are_made_from_its_record(tmp_path):
    folder = killed_run(tmp_path / "killed")
    before = read_run(folder)
    assert "incomplete" in before.note
    assert "1.84 s" in before.note
    said = complete(folder)
    assert "messages of" in said
    assert f"{folder / SUMMARY}" in said
    after = read_run(folder)
    assert (after.note, after.log) == ("", replace(after.log, poses=before.log.poses, truth=before.log.truth))
    summary = json.loads((folder / SUMMARY).read_text())
    assert (summary["outcome"], summary["reached"], summary["simulated"]) == (KILLED, False, True)
    assert (folder / "impacts.csv").read_text().count("\n") == 2
    assert complete(folder).endswith("is whole")


def test_a_run_that_is_still_written_is_left_alone(tmp_path):
    folder = killed_run(tmp_path / "run")
    lock = FolderLock(folder)
    with pytest.raises(RunError, match=BEING_WRITTEN):
        complete(folder)
    said: list[str] = []
    assert (complete_newest(tmp_path, said.append), said) == ("", [])
    lock.close()
    assert RECORDING in complete_newest(tmp_path)
    assert complete_newest(tmp_path) == ""


def test_replay_finishes_a_run_named_by_its_recording_or_says_why_not(tmp_path, capsys):
    folder = killed_run(tmp_path / "run")
    assert main(["--finish", str(folder / RECORDING)]) == 0
    assert "completed" in capsys.readouterr().out
    for path, words in ((tmp_path / "gone" / RECORDING, "not a folder"), (tmp_path, f"no {RECORDING}")):
        assert main(["--finish", str(path)]) == 2
        assert words in capsys.readouterr().err
