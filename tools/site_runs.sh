#!/bin/sh
# site_runs.sh: `make site-runs`: the runs that docs/runs.md plays, simulated anew, their pages in docs/runs, with one
# script and one style beside them. Where a run does not reach its goal, or all is too large together, docs/runs stays.
set -eu
cd "$(dirname "$0")/.."
largest=1600000 # bytes
runs=runs/site
rm -rf "$runs"
mkdir -p "$runs/pages"

drive() {
    name=$1
    shift
    "$VENV/bin/bringup" --no-journal --out "$runs/$name" "$@"
}
play() {
    drive "$@"
    cp "$runs/$1/latest/run.html" "$runs/pages/$1.html"
}

drive avoid --world "$SERPENTINE" --strategy avoid --no-pictures
drive bounce --world "$SERPENTINE" --strategy bounce --no-pictures
"$VENV/bin/beside" "$runs/avoid/latest" "$runs/bounce/latest" --out "$runs/pages/serpentine.html"
play u --world u:17 --strategy bounce
play clutter --world random:7 --strategy bounce
play corridor --world corridor --strategy harness
play crossing --world examples/crossing.yaml --strategy bounce

# somebody drives a robot whose LIDAR hangs upside down, turned, off the middle, its stamps late
PYTHONPATH="tests:tests/runs${PYTHONPATH:+:$PYTHONPATH}" "$VENV/bin/python" - "$runs" <<'DRIVE'
import sys
from pathlib import Path

from driven_robots import Drive, Mount, driven
from test_inspect import write_bag

mount = Mount(late=-0.15, x=0.12, y=-0.05, yaw=1.9, sweep=1, mirrored=True)
write_bag(Path(sys.argv[1]), "mcap", driven(mount, Drive(), duration=10.0, seed=3))
DRIVE
"$VENV/bin/inspect" "$runs/drive" --out "$runs/inspect"
cp "$runs/inspect/inspect.html" "$runs/pages"

# one script and one style for all pages; no module, of which a browser loads none beside a page that is opened as a file
"$VENV/bin/python" - "$runs/pages" <<'SHARE'
import re
import sys
from pathlib import Path

PARTS = (
    ("<style>(.*?)</style>", "page.css", '<link rel="stylesheet" href="page.css">', "{}"),
    ('<script type="module">(.*?)</script>', "page.js", '<script src="page.js" defer></script>', "(() => {{\n{}}})();\n"),
)
for page in Path(sys.argv[1]).glob("*.html"):
    text = re.sub("'sha256-[^']*'", "'self' file:", page.read_text())
    for inline, name, link, form in PARTS:
        found = re.search(inline, text, re.DOTALL)
        page.with_name(name).write_text(form.format(found[1]))
        text = text.replace(found[0], link)
    page.write_text(text)
SHARE

size=$(cat "$runs"/pages/* | wc -c)
[ "$size" -le "$largest" ] || {
    echo "site-runs: the pages in $runs/pages are $size bytes together, expected at most $largest" >&2
    exit 1
}
rm -rf docs/runs
cp -R "$runs/pages" docs/runs
echo "docs/runs: $size bytes"
