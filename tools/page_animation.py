"""An animation of a run as its run.html plays it: a screenshot for each frame by Chromium, which has to be installed.

.venv/bin/python tools/page_animation.py runs/latest/run.html run.webp
"""

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = ("--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars")
DARK = "--blink-settings=preferredColorScheme=0"
DRAWN_WITHIN = 3000
"""Time that the page is given to unpack the run and to draw, in its own clock, which runs as fast as it can [ms]."""
LAST_FRAME = 1.5
"""How long the last frame stays [s]."""


def main() -> int:
    """Writes the animation."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", type=Path, metavar="RUN.HTML", help="in the folder of a run that reached its goal")
    parser.add_argument("animation", type=Path, metavar="FILE", help="where to, .webp or .gif")
    parser.add_argument("--width", type=int, default=1280, help="of the page [pixel] (default 1280)")
    parser.add_argument("--height", type=int, default=800, help="of the page [pixel] (default 800)")
    parser.add_argument("--rate", type=float, default=10.0, metavar="HZ", help="frames per second (default 10)")
    parser.add_argument("--dark", action="store_true", help="in dark colours")
    options = parser.parse_args()
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        parser.error(f"no browser found, expected one of {', '.join(BROWSERS)}")
    arrival = json.loads(options.page.with_name("summary.json").read_text())["arrival_time_s"]
    if arrival is None:
        parser.error(f"{options.page}: a run that did not reach its goal, expected one that did")
    period = 1.0 / options.rate
    command = [browser, *FLAGS, f"--window-size={options.width},{options.height}", *[DARK] * options.dark]
    first, *others = screenshots(command, options.page.resolve().as_uri(), np.arange(0.0, arrival + period, period))
    durations = [round(1e3 * period)] * len(others) + [round(1e3 * LAST_FRAME)]
    first.save(options.animation, save_all=True, append_images=others, duration=durations, loop=0, method=6)
    print(f"{options.animation}, {len(durations)} frames, {options.animation.stat().st_size / 1000:.0f} kB")
    return 0


def screenshots(command: list[str], page: str, moments: np.ndarray) -> Iterator[Image.Image]:
    """The page at these times of the run [s]."""
    with tempfile.TemporaryDirectory() as work:
        shot = Path(work, "shot.png")
        command += [f"--user-data-dir={work}/profile", f"--virtual-time-budget={DRAWN_WITHIN}", f"--screenshot={shot}"]
        for moment in moments:
            address = f"{page}#t={moment:.2f}"
            subprocess.run([*command, address], check=True, capture_output=True, timeout=60.0)
            yield Image.open(shot).convert("RGB")
            shot.unlink()


if __name__ == "__main__":
    sys.exit(main())
