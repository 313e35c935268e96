#!/bin/sh
# site_runs.sh: `make site-runs`: the runs that docs/runs.md plays, simulated anew, their pages in docs/runs. Where a run
# does not reach its goal, or the pages are too large together, all pages stay as they are.
set -eu
cd "$(dirname "$0")/.."
largest=3000000 # bytes
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

size=$(cat "$runs"/pages/*.html | wc -c)
[ "$size" -le "$largest" ] || {
    echo "site-runs: the pages in $runs/pages are $size bytes together, expected at most $largest" >&2
    exit 1
}
mkdir -p docs/runs
cp "$runs"/pages/*.html docs/runs
echo "docs/runs: $size bytes"
