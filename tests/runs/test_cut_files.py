"""Files that a power cut left in half: every reader says so in a sentence, and none calls them whole."""

import runpy
import shutil
from contextlib import suppress
from pathlib import Path

import pytest

from collplan_ros.replay.main import SAME
from collplan_ros.replay.main import main as replay
from collplan_ros.run.completion import complete
from collplan_ros.run.page.beside import main as beside
from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.whole_file import RunError

RECORDED = Path(__file__).parents[1] / "frozen" / "runs" / "simulated"
CUTS = {
    "empty": lambda held: b"",
    "one byte": lambda held: held[:1],
    "a tenth": lambda held: held[: len(held) // 10],
    "half": lambda held: held[: len(held) // 2],
    "last byte": lambda held: held[:-1],
    "last 9 bytes": lambda held: held[:-9],
    "half zeros": lambda held: held[: len(held) // 2] + bytes(len(held) - len(held) // 2),
}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A run with all that bringup writes."""
    folder = shutil.copytree(RECORDED, tmp_path_factory.mktemp("runs") / "whole")
    complete(folder)
    assert complete(folder) == f"{folder}: is whole"
    return folder


@pytest.fixture
def cut(whole, tmp_path):
    """Cuts a file of a copy of the run."""

    def cut_file(name: str, how: str) -> Path:
        folder = shutil.copytree(whole, tmp_path / "run")
        path = folder / name
        path.write_bytes(CUTS[how](path.read_bytes()))
        return folder

    return cut_file


@pytest.mark.parametrize("how", CUTS)
def test_a_cut_recording_is_not_called_whole(cut, how):
    folder = cut("run.mcap", how)
    if how in ("empty", "one byte"):
        for read in (read_run, complete):
            with pytest.raises(RunError, match=r"run\.mcap"):
                read(folder)
        return
    assert "recording is cut off" in read_run(folder).note
    assert "had no end; completed" in complete(folder)
    assert read_run(folder).note == ""


@pytest.mark.parametrize("how", CUTS)
def test_cut_parameters_are_taken_from_the_recording(cut, whole, how):
    folder = cut("parameters.yaml", how)
    assert read_run(folder).settings == read_run(whole).settings
    assert "parameters.yaml is made from run.mcap" in complete(folder)
    assert (folder / "parameters.yaml").read_bytes() == (whole / "parameters.yaml").read_bytes()


@pytest.mark.parametrize("how", CUTS)
def test_a_cut_summary_is_made_anew(cut, whole, how):
    folder = cut("summary.json", how)
    if how == "half zeros":
        (folder / "summary.json").write_bytes(b"{\0\0\0")
    assert "bringup ended before the run did" in read_run(folder).note
    assert "summary.json and the other results are made" in complete(folder)
    assert (folder / "summary.json").read_bytes() == (whole / "summary.json").read_bytes()


@pytest.mark.parametrize("name", ["trajectory.csv", "impacts.csv"])
@pytest.mark.parametrize("how", ["empty", "one byte", "last byte", "half zeros"])
def test_a_cut_table_is_named(cut, name, how):
    assert f"{name} cut off: remove summary.json" in complete(cut(name, how))


@pytest.mark.parametrize(("name", "said"), [("run.mcap", "recording is cut off"), ("summary.json", "bringup ended")])
def test_runs_beside_each_other_say_which_is_cut(cut, whole, tmp_path, capsys, name, said):
    folder = cut(name, "last byte")
    assert beside([str(whole), str(folder), "--out", str(tmp_path / "both.html")]) == SAME
    said_of = [line for line in capsys.readouterr().out.splitlines() if "incomplete" in line]
    assert len(said_of) == 1
    assert said_of[0].startswith(str(folder))
    assert said in said_of[0]


@pytest.mark.parametrize("how", ["a tenth", "half", "last byte", "last 9 bytes", "half zeros"])
def test_the_script_of_examples_says_that_a_recording_is_cut(cut, monkeypatch, capsys, how):
    script, folder = Path(__file__).parents[2] / "examples" / "recorded_run.py", cut("run.mcap", how)
    monkeypatch.chdir(folder)
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.setattr("sys.argv", [script.name, "."])
    with suppress(SystemExit):  # it may hold no pose
        runpy.run_path(str(script), run_name="__main__")
    assert "run.mcap: has no end, it is cut off" in capsys.readouterr().out


def test_the_page_of_a_cut_run_says_so(cut, capsys):
    assert replay(["--page", str(cut("run.mcap", "half"))]) == SAME
    assert "recording is cut off" in capsys.readouterr().out
