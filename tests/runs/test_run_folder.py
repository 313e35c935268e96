"""The folder of a run and the link to the newest."""

import pytest

from collplan_ros.bringup.failures import StartError
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.runs.folder_lock import FolderLock


def test_runs_of_the_same_second_have_folders_of_their_own(tmp_path):
    folders = [RunFolder(tmp_path) for _ in range(3)]
    for folder in folders:
        folder.become_latest()
    assert len({folder.path for folder in folders}) == 3
    assert (tmp_path / "latest").resolve() == folders[-1].path
    folders[0].discard()
    assert sorted(entry.name for entry in tmp_path.iterdir()) == sorted(
        ["latest", folders[1].path.name, folders[2].path.name]
    )


def test_a_folder_that_cannot_be_written_is_one_clear_line(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(StartError, match=r"run folder .*file/runs: cannot be written: Not a directory"):
        RunFolder(tmp_path / "file" / "runs")
    (tmp_path / "latest" / "in_the_way").mkdir(parents=True)
    with pytest.raises(StartError, match="latest: cannot be written"):
        RunFolder(tmp_path).become_latest()


def test_a_folder_is_locked_until_its_run_is_over(tmp_path):
    folder = RunFolder(tmp_path)
    with pytest.raises(BlockingIOError):
        FolderLock(folder.path)
    folder.close()
    FolderLock(folder.path).close()
