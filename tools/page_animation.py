"""An animation of runs as their page plays them, run.html or one of `beside`, by Chromium, which has to be installed.

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
END = "Number(document.querySelector('#transport .bar').max)"
SHOWN = """new Promise((shown) => {{
  location.hash = "t={moment:.3f}";
  setTimeout(() => requestAnimationFrame(() => requestAnimationFrame(shown)), 150);
}})"""
"""The page draws its plots every 100 ms."""
WIDTH, HEIGHT, SCALE = 1200, 800, 0.75
"""Size of the page [pixel], and screen pixels drawn for each of its pixels."""
PERIOD, LAST_FRAME = 0.08, 1.5
"""Duration of a frame, and of the last one [s]."""


def main() -> int:
    """Writes the animation."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", type=Path, metavar="PAGE", help="run.html, or a page of beside")
    parser.add_argument("animation", type=Path, metavar="FILE", help="where to, .webp or .gif")
    options = parser.parse_args()
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        sys.exit(f"{options.page} is not animated: no Chromium found, expected one of {', '.join(BROWSERS)}")
    with opened(browser, options.page.resolve().as_uri(), UNPACKED) as page:
        set_up(page)
        first, *others = screenshots(page)
    durations = [round(1e3 * PERIOD)] * len(others) + [round(1e3 * LAST_FRAME)]
    first.save(options.animation, save_all=True, append_images=others, duration=durations, loop=0, method=6)
    print(f"{options.animation}, {len(durations)} frames, {options.animation.stat().st_size / 1000:.0f} kB")
    return 0


@contextmanager
def opened(browser: str, address: str, ready: str) -> Iterator[ClientConnection]:
    """A connection to a page in a browser of its own, by DevTools, once an expression is true in it.

    Raises TimeoutError where browser or page are not ready within PATIENCE.
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


def set_up(page: ClientConnection) -> None:
    """Sets the size of the page, in light colours."""
    screen = {"width": WIDTH, "height": HEIGHT, "deviceScaleFactor": SCALE, "mobile": False}
    _asked(page, "Emulation.setDeviceMetricsOverride", **screen)
    _asked(page, "Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "light"}])


def screenshots(page: ClientConnection) -> Iterator[Image.Image]:
    """The page from the first command to move on, every PERIOD."""
    for moment in np.arange(0.0, _evaluated(page, END) + PERIOD, PERIOD):
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
