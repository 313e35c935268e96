"""Files that a power cut left in half: every reader says so in a sentence, and none calls them whole."""

import shutil
from pathlib import Path

import pytest

from collplan_ros.replay.main import SAME
from collplan_ros.run.page.beside import main as beside
from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.result_files import complete
from collplan_ros.run.whole_file import RunError

RECORDED = Path(__file__).parents[1] / "frozen" / "runs" / "simulated"
CUTS = {
    "empty": lambda held: b"",
    "half": lambda held: held[: len(held) // 2],
    "last byte": lambda held: held[:-1],
    "half zeros": lambda held: held[: len(held) // 2] + bytes(len(held) - len(held) // 2),
}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = shutil.copytree(RECORDED, tmp_path_factory.mktemp("runs") / "whole")
    complete(folder)
    assert read_run(folder).note == ""
    return folder


@pytest.fixture
def cut(whole, tmp_path):

    def cut_file(name: str, how: str) -> Path:
        folder = shutil.copytree(whole, tmp_path / "run")
        path = folder / name
        path.write_bytes(CUTS[how](path.read_bytes()))
        return folder

    return cut_file


@pytest.mark.parametrize("how", CUTS)
def test_a_cut_recording_is_not_called_whole(cut, how):
    folder = cut("run.mcap", how)
    if how == "empty":
        with pytest.raises(RunError, match=r"run\.mcap"):
            read_run(folder)
        return
    assert "recording is cut off" in read_run(folder).note


@pytest.mark.parametrize("how", ["empty", "half zeros"])
def test_cut_parameters_are_taken_from_the_recording_and_a_cut_summary_is_made_anew(cut, whole, how):
    folder = cut("parameters.yaml", how)
    assert read_run(folder).settings == read_run(whole).settings
    summary = folder / "summary.json"
    summary.write_bytes(b"{\0\0\0" if how == "half zeros" else CUTS[how](summary.read_bytes()))
    assert read_run(folder).note == ""  # the recording holds its end
    assert "summary.json and the other results are made" in complete(folder)
    assert summary.read_bytes() == (whole / "summary.json").read_bytes()


def test_runs_beside_each_other_say_which_is_cut(cut, whole, tmp_path, capsys):
    folder = cut("run.mcap", "last byte")
    assert beside([str(whole), str(folder), "--out", str(tmp_path / "both.html")]) == SAME
    said_of = [line for line in capsys.readouterr().out.splitlines() if "incomplete" in line]
    assert len(said_of) == 1
    assert said_of[0].startswith(str(folder))
    assert "recording is cut off" in said_of[0]
