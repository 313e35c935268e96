"""Pictures of a run hold it: two runs beside each other; what cannot be drawn is named."""

import numpy as np
import pytest
from PIL import Image

from collplan_ros.pictures.compare_runs import main
from collplan_ros.pictures.palette import DELIBERATE, OTHER
from collplan_ros.pictures.side_by_side import FRAME_PERIOD, GAP, HEAD, LAST_FRAME
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
    for panel in (slice(None, width), slice(-width, None)):
        shown = [frame[HEAD:-FEET, panel] for frame, _ in frames]
        for color in (DELIBERATE, OTHER):
            counts = [count_of(each, color) for each in shown]
            assert max(counts[: round(HITS[0] / FRAME_PERIOD)]) < 5 < counts[-1]


def test_one_run_or_two_worlds_are_refused(folders, tmp_path, capsys):
    other = drawn_folder(tmp_path, "other", 0.2, world="slalom")
    for runs, said in ((folders[:1], "at least two"), ((folders[0], other), "corridor, slalom")):
        assert main([*map(str, runs), "--out", str(tmp_path / "no.gif")]) == REFUSED
        assert said in capsys.readouterr().err
    assert not (tmp_path / "no.gif").exists()
