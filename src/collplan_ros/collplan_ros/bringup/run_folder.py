"""The folder with the files of one run, and the link to the newest."""

import os
import shutil
import tempfile
from collections.abc import Callable
from contextlib import suppress
from datetime import datetime
from itertools import count
from pathlib import Path

from collplan_core.parameters import Settings
from collplan_core.parameters.file import write_parameters
from collplan_ros.bringup.ending import StartError
from collplan_ros.run.description import PARAMETERS
from collplan_ros.run.whole_file import FolderLock
from collplan_ros.run.writer import RECORDING


class RunFolder:
    """The folder `parent/<time>/` of one run; locked until `close()`, so that nobody makes its results."""

    def __init__(self, parent: Path, settings: Settings) -> None:
        """Makes the folder, and writes the parameters of a run into it; StartError where it cannot."""
        if not _is_utf8(parent.absolute()):
            raise StartError(
                f"run folder {parent}: cannot be told to ROS, which reads paths as UTF-8: set LC_ALL=C.UTF-8"
            )
        if parent.is_file():
            raise StartError(f"run folder {parent}: is a file, expected a folder")
        try:
            self.path = _new_folder(parent)
            self.logs = self.path / "log"
            """Folder of the nodes' output."""
            self.logs.mkdir()
            self.parameters, self.recording = self.path / PARAMETERS, self.path / RECORDING
            write_parameters(settings, self.parameters)
        except OSError as error:
            raise StartError(f"run folder {parent}: cannot be written: {error.strerror or error}") from None
        self.serial = self.path / "serial"
        """Link to the pseudo-terminal of an emulated firmware while it runs."""
        try:
            self.serial.symlink_to(self.path)
            self.serial.unlink()
        except OSError:  # of a file system without links
            self.serial = Path(tempfile.mkdtemp(prefix="collplan-")) / "serial"
        self.close: Callable[[], None] = lambda: None
        """Unlocks it, once its files are written or have failed to be."""
        # where a file system knows no locks, nobody can lock it to complete it either
        with suppress(OSError):
            self._lock = FolderLock(self.path)
            self.close = self._lock.close

    def become_latest(self) -> str:
        """Makes the link `latest`, beside the folder, point to it; returns why it cannot be made, or ""."""
        # replaced atomically: there is no moment without a link
        latest, fresh = self.path.parent / "latest", self.path.parent / f".latest_{os.getpid()}"
        try:
            fresh.unlink(missing_ok=True)
            fresh.symlink_to(self.path.name)
            os.replace(fresh, latest)
        except OSError as error:
            with suppress(OSError):
                fresh.unlink(missing_ok=True)
            return f"no link {latest}: {error.strerror or error}; the run is in {self.path}"
        return ""

    def discard(self) -> None:
        """Removes the folder, for a run that did not start."""
        shutil.rmtree(self.path)


def _is_utf8(path: Path) -> bool:
    try:
        return str(path).encode() == os.fsencode(path)
    except UnicodeEncodeError:
        return False


def _new_folder(parent: Path) -> Path:
    parent.mkdir(parents=True, exist_ok=True)
    stem = datetime.now().strftime("%Y-%m-%d_%H-%M-%S")
    for number in count(1):
        path = parent / (stem if number == 1 else f"{stem}_{number}")
        with suppress(FileExistsError):
            path.mkdir()
            return path.resolve()
    raise AssertionError("unreachable")
