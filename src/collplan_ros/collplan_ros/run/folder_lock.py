"""The lock on a run folder that is being written: nobody completes it meanwhile."""

import fcntl
import os
import weakref
from pathlib import Path


class FolderLock:
    """Held from its construction until it is closed, or its process ends, whatever ends it.

    Raises:
        BlockingIOError: on construction, another holds it.
        OSError: on construction, the folder cannot be read, or is where a file system knows no locks.
    """

    def __init__(self, folder: Path) -> None:
        """Takes the lock."""
        descriptor = os.open(folder, os.O_RDONLY)
        self.close = weakref.finalize(self, os.close, descriptor)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self.close()
            raise
