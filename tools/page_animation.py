"""An animation of a run as its run.html plays it, by Chromium, which has to be installed.

.venv/bin/python tools/page_animation.py runs/latest/run.html run.webp
"""

import argparse
import base64
import json
import shutil
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from PIL import Image
from websockets.sync.client import ClientConnection, connect

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = ("--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--remote-debugging-port=0")
PATIENCE = 60.0
"""For the browser to start, to open the page, and to answer [s]."""
POLLED = 0.05
"""Time between two looks whether it has [s]."""
UNPACKED = "document.getElementById('transport')?.hidden === false"
SHOWN = """new Promise((shown) => {{
  location.hash = "t={moment:.3f}";
  setTimeout(() => requestAnimationFrame(() => requestAnimationFrame(shown)), 150);
}})"""
"""The page draws its plots every 100 ms."""
LAST_FRAME = 1.5
"""How long the last frame stays [s]."""


def main() -> int:
    """Writes the animation."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", type=Path, metavar="RUN.HTML", help="in the folder of a run that reached its goal")
    parser.add_argument("animation", type=Path, metavar="FILE", help="where to, .webp or .gif")
    parser.add_argument("--width", type=int, default=1200, help="of the page [pixel] (default 1200)")
    parser.add_argument("--height", type=int, default=800, help="of the page [pixel] (default 800)")
    parser.add_argument("--scale", type=float, default=0.75, help="pixels drawn for each of them (default 0.75)")
    parser.add_argument("--rate", type=float, default=12.5, metavar="HZ", help="frames per second (default 12.5)")
    parser.add_argument("--dark", action="store_true", help="in dark colours")
    options = parser.parse_args()
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        parser.error(f"no browser found, expected one of {', '.join(BROWSERS)}")
    arrival = json.loads(options.page.with_name("summary.json").read_text())["arrival_time_s"]
    if arrival is None:
        parser.error(f"{options.page}: a run that did not reach its goal, expected one that did")
    period = 1.0 / options.rate
    with opened(browser, options.page.resolve().as_uri(), UNPACKED) as page:
        set_up(page, (options.width, options.height), options.scale, options.dark)
        first, *others = screenshots(page, np.arange(0.0, arrival + period, period))
    durations = [round(1e3 * period)] * len(others) + [round(1e3 * LAST_FRAME)]
    first.save(options.animation, save_all=True, append_images=others, duration=durations, loop=0, method=6)
    print(f"{options.animation}, {len(durations)} frames, {options.animation.stat().st_size / 1000:.0f} kB")
    return 0


@contextmanager
def opened(browser: str, address: str, ready: str) -> Iterator[ClientConnection]:
    """A connection to a page in a browser of its own, by Chrome's DevTools protocol, once an expression is true in it.

    Raises:
        TimeoutError: browser or page are not ready within PATIENCE.
    """
    with TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        process = subprocess.Popen([browser, *FLAGS, f"--user-data-dir={profile}", address], stderr=subprocess.DEVNULL)
        try:
            with connect(_target(Path(profile, "DevToolsActivePort")), max_size=None, proxy=None) as page:
                _wait_for(lambda: _evaluated(page, ready))
                yield page
        finally:
            process.terminate()
            process.wait(PATIENCE)


def set_up(page: ClientConnection, size: tuple[int, int], scale: float, dark: bool) -> None:
    """Sets width and height of the page [pixel], how many are drawn for each of them, and whether it is dark."""
    screen = {"width": size[0], "height": size[1], "deviceScaleFactor": scale, "mobile": False}
    _asked(page, "Emulation.setDeviceMetricsOverride", **screen)
    theme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
    _asked(page, "Emulation.setEmulatedMedia", features=[theme])


def screenshots(page: ClientConnection, moments: np.ndarray) -> Iterator[Image.Image]:
    """The page at these times of the run [s]."""
    for moment in moments:
        _evaluated(page, SHOWN.format(moment=moment))
        png = base64.b64decode(_asked(page, "Page.captureScreenshot", format="png")["data"])
        yield Image.open(BytesIO(png)).convert("RGB")


def _target(port_file: Path) -> str:
    """Address of the websocket of the one page of a browser that writes its port here."""
    _wait_for(lambda: port_file.exists() and port_file.read_text().count("\n"))
    port = port_file.read_text().splitlines()[0]
    with urllib.request.urlopen(f"http://127.0.0.1:{port}/json/list") as answer:
        return next(each["webSocketDebuggerUrl"] for each in json.load(answer) if each["type"] == "page")


def _evaluated(page: ClientConnection, expression: str) -> Any:
    """Value of an expression, or of what it promises, in the page."""
    answer = _asked(page, "Runtime.evaluate", expression=expression, awaitPromise=True)
    if "exceptionDetails" in answer:
        raise RuntimeError(f"{expression}: {answer['exceptionDetails']['text']}")
    return answer["result"].get("value")


def _asked(page: ClientConnection, method: str, **parameters: Any) -> dict[str, Any]:
    """What the browser answers; only one question is asked at a time, and nobody has asked for events."""
    page.send(json.dumps({"id": 1, "method": method, "params": parameters}))
    answer = json.loads(page.recv(timeout=PATIENCE))
    if "error" in answer:
        raise RuntimeError(f"{method}: {answer['error']['message']}")
    return answer["result"]


def _wait_for(condition: Callable[[], Any]) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError(f"the browser has not opened the page within {PATIENCE:g} s")
        time.sleep(POLLED)


if __name__ == "__main__":
    sys.exit(main())
