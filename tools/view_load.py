"""What the live page costs: processor time of view_node and bytes to each page, with 0, 1 and 5 pages open.

    make demo                                  # in one terminal
    .venv/bin/python tools/view_load.py        # in another

The pages are clients that read and draw nothing; the browser's own work is not in it.
"""

import argparse
import os
import threading
import time
from contextlib import suppress
from pathlib import Path

from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

PORT = 8090
"""view.port as shipped."""
SETTLING = 3.0
"""Time before each measurement [s]."""
LINGER = 12.0
"""The same with no page: view_node listens on for a while after the last one [s]."""


def view_node() -> int:
    """Process id of the view_node of this machine."""
    for entry in Path("/proc").iterdir():
        with suppress(OSError):
            if entry.name.isdigit() and "/view_node\0--ros-args" in (entry / "cmdline").read_text():
                return int(entry.name)
    raise SystemExit("view_load: no view_node runs, expected one, as of make demo")


def processor_time(pid: int) -> float:
    """Time that a process has computed so far [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Page(threading.Thread):
    """Reads what comes, and counts it, from when the server is there."""

    def __init__(self, port: int, end: threading.Event) -> None:
        super().__init__(daemon=True)
        self.bytes = self.frames = 0
        self._port, self._end = port, end

    def run(self) -> None:
        while not self._end.wait(0.1):
            with suppress(OSError, WebSocketException):
                self._read()

    def _read(self) -> None:
        host = f"127.0.0.1:{self._port}"
        with connect(f"ws://{host}/frames", origin=f"http://{host}", compression=None, proxy=None) as socket:
            while not self._end.is_set():
                with suppress(TimeoutError):
                    self.bytes += len(socket.recv(timeout=0.2))
                    self.frames += 1


def measure(pid: int, port: int, n_pages: int, duration: float) -> str:
    """A row of the table."""
    end = threading.Event()
    pages = [Page(port, end) for _ in range(n_pages)]
    for page in pages:
        page.start()
    time.sleep(SETTLING if pages else LINGER)
    begun, computed = time.monotonic(), processor_time(pid)
    before = [(page.bytes, page.frames) for page in pages]
    time.sleep(duration)
    passed = time.monotonic() - begun
    share = (processor_time(pid) - computed) / passed
    sent = [(page.bytes - bytes_, page.frames - frames) for page, (bytes_, frames) in zip(pages, before, strict=True)]
    end.set()
    for page in pages:
        page.join()
    rate = max((bytes_ for bytes_, _ in sent), default=0) / passed
    frames = min((frames for _, frames in sent), default=0) / passed
    return f"| {n_pages} | {100 * share:.1f} % | {1e-3 * rate:.0f} | {frames:.1f} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--port", type=int, default=PORT, help="view.port (default 8090)")
    parser.add_argument("--pages", type=int, nargs="+", default=[0, 1, 5], help="how many pages (default 0 1 5)")
    parser.add_argument("--duration", type=float, default=20.0, help="length of each measurement [s] (default 20)")
    options = parser.parse_args()
    pid = view_node()
    print("| pages | of a core | kB/s to each | frames/s |\n|---|---|---|---|")
    for n_pages in options.pages:
        print(measure(pid, options.port, n_pages, options.duration), flush=True)


if __name__ == "__main__":
    main()
