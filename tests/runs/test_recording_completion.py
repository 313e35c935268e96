"""A recording whose bringup was killed is read as far as it was closed, and the results are made from it."""

import json
import tempfile
from contextlib import closing
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_ros.replay.main import main as replay
from collplan_ros.run.page.beside import main as beside
from collplan_ros.run.reader import raw_messages
from collplan_ros.run.recorded_run import SUMMARY, read_run
from collplan_ros.run.result_files import KILLED, complete
from collplan_ros.run.whole_file import FolderLock
from collplan_ros.run.writer import LIBRARY, RECORDING
from made_recordings import TOPICS, MadeRecording, String, point
from made_runs import killed_run

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


def read(content: bytes) -> list[tuple[str, int, bytes]]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / RECORDING
        path.write_bytes(content)
        return rows_of(path)


@given(st.integers(HEADER, len(WHOLE)))
def test_a_recording_cut_off_anywhere_holds_every_chunk_that_was_closed(cut):
    rows = read(WHOLE[:cut])
    assert rows == ROWS[: len(rows)]
    assert len(rows) >= IN_CHUNK * sum(size <= cut for size in SIZES)
    assert len(rows) % IN_CHUNK == 0


@given(st.integers(HEADER, len(WHOLE) - 1), st.integers(1, 255))
def test_what_a_broken_disk_has_changed_is_left_out_and_nothing_is_made_up(at, change):
    changed = bytearray(WHOLE)
    changed[at] ^= change
    assert set(read(bytes(changed))) <= set(ROWS)


def test_a_chunk_that_cannot_be_read_costs_no_other():
    changed = bytearray(WHOLE)
    changed[SIZES[1] + 60] ^= 0xFF
    assert read(bytes(changed)) == [*ROWS[: 2 * IN_CHUNK], *ROWS[3 * IN_CHUNK :]]


# ---- the run folder


@pytest.mark.parametrize(
    ("program", "asked", "runs"), [(replay, ["--page"], ["killed"]), (beside, ["--out", "page.html"], ["killed"] * 2)]
)
def test_the_results_of_a_killed_run_are_made_when_it_is_read(tmp_path, monkeypatch, capsys, program, asked, runs):
    monkeypatch.chdir(tmp_path)
    folder = killed_run(tmp_path / "killed")
    recording = (folder / RECORDING).read_bytes()
    assert "1.84 s" in read_run(folder).note
    assert program([*asked, *runs]) == 0
    assert f"killed/{SUMMARY} and the other results are made" in capsys.readouterr().out
    summary = json.loads((folder / SUMMARY).read_text())
    assert (summary["outcome"], summary["reached"], summary["simulated"]) == (KILLED, False, True)
    assert (folder / "impacts.csv").read_text().count("\n") == 2
    assert (folder / RECORDING).read_bytes() == recording
    assert complete(folder) == ""


def test_a_run_that_is_still_written_or_cannot_be_read_is_left_as_it_is(tmp_path):
    folder = killed_run(tmp_path / "run")
    with closing(FolderLock(folder)):
        assert BEING_WRITTEN in complete(folder)
    assert not (folder / SUMMARY).exists()
    (folder / RECORDING).write_bytes(b"t,x,y\n")
    assert "is not made" in complete(folder)
    assert (folder / RECORDING).read_bytes() == b"t,x,y\n"
    assert complete(tmp_path) == ""
