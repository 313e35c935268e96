"""Pictures of a run hold it: two runs beside each other; what cannot be drawn is named."""

from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from collplan_ros.pictures.compare_runs import main
from collplan_ros.pictures.palette import DELIBERATE, OTHER
from collplan_ros.pictures.shown_run import read_shown_run
from collplan_ros.pictures.side_by_side import FRAME_PERIOD, GAP, HEAD, LAST_FRAME
from collplan_ros.pictures.title import wrapped
from collplan_ros.runs.run_error import RunError
from collplan_ros.runs.trajectory_file import COLUMNS as TRAJECTORY_COLUMNS
from played_folders import HITS, drawn_folder

WRITTEN, REFUSED = 0, 2
FEET = 60
"""Height of the text below a picture, at least [pixel]."""


def frames_of(path):
    """Each frame of a GIF as an array, and how long it stays [ms]."""
    with Image.open(path) as image:
        found = []
        for k in range(image.n_frames):
            image.seek(k)
            found.append((np.asarray(image.convert("RGB")).astype(int), image.info["duration"]))
    return found


def count_of(frame, color):
    """Number of pixels above the text that have a colour, but for the rounding of a palette."""
    wanted = [int(color[i : i + 2], 16) for i in (1, 3, 5)]
    return int((np.abs(frame[:-FEET] - wanted).max(axis=2) <= 6).sum())


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    parent = tmp_path_factory.mktemp("runs")
    return drawn_folder(parent, "slow", 0.6, strategy="avoid"), drawn_folder(parent, "fast", 0.4)


def test_runs_beside_each_other_share_one_clock_and_each_stays_where_it_ended(folders, tmp_path):
    out = tmp_path / "both.gif"
    assert main([*map(str, folders), "--out", str(out)]) == WRITTEN
    frames = frames_of(out)
    assert len(frames) == int(0.6 / FRAME_PERIOD) + 2
    *durations, last = (duration for _, duration in frames)
    assert set(durations) == {1e3 * FRAME_PERIOD}
    assert last == pytest.approx(1e3 * LAST_FRAME, abs=2e3 * FRAME_PERIOD)
    width = (frames[0][0].shape[1] - GAP) // 2
    panels = [(frame[HEAD:-FEET, :width], frame[HEAD:-FEET, -width:]) for frame, _ in frames]
    for panel, duration in enumerate((0.6, 0.4)):
        shown = [each[panel] for each in panels]
        changes = [int((np.abs(b - a).max(axis=2) > 40).sum()) for a, b in pairwise(shown)]
        ended = round((duration + 0.3) / FRAME_PERIOD)  # a mark is drawn larger at first
        assert min(changes[: round(duration / FRAME_PERIOD)]) > 20
        assert max(changes[ended:], default=0) == 0
        for color in (DELIBERATE, OTHER):
            counts = [count_of(each, color) for each in shown]
            assert max(counts[: round(HITS[0] / FRAME_PERIOD)]) < 5
            assert counts[-1] > 5


def test_a_title_is_broken_between_words_and_within_those_that_are_too_long():
    assert wrapped("one two\nthree", lambda text: len(text) <= 4) == "one\ntwo\nthre\ne"


def test_one_run_or_two_worlds_are_refused(folders, tmp_path, capsys):
    other = drawn_folder(tmp_path, "other", 0.2, world="slalom")
    for runs, said in ((folders[:1], "at least two"), ((folders[0], other), "corridor, slalom")):
        assert main([*map(str, runs), "--out", str(tmp_path / "no.gif")]) == REFUSED
        assert said in capsys.readouterr().err
    assert not (tmp_path / "no.gif").exists()


def test_what_bringup_did_not_write_is_named(tmp_path):
    for number, (file, found, put, said) in enumerate(
        (
            ("impacts.csv", "deliberate", "on_purpose", "no column deliberate"),
            ("impacts.csv", ",true\r\n", ",perhaps\r\n", "line 2, deliberate: got 'perhaps'"),
            ("impacts.csv", "0.9", "nine", "line 2, x: got 'nine'"),
            ("summary.json", '"goal"', '"gaol"', "expected JSON"),
            ("trajectory.csv", None, ",".join(TRAJECTORY_COLUMNS) + "\n", "no poses"),
        )
    ):
        folder = drawn_folder(tmp_path, f"run_{number}", 0.2)
        text = (folder / file).read_bytes().decode()
        (folder / file).write_bytes((text.replace(found, put) if found else put).encode())
        with pytest.raises(RunError, match=said) as error:
            read_shown_run(folder)
        assert file in str(error.value)
