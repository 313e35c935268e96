"""The benchmark runs without its peers and writes what it promises."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.soak
def test_bench_writes_its_figures_and_says_which_peers_it_skipped(tmp_path: Path) -> None:
    out = tmp_path / "bench.json"
    smallest = ["--rounds", "1", "--seeds", "1", "--clutter", "0", "--families", "u"]
    options = ["--no-peers", *smallest, "--out", str(out)]
    done = subprocess.run([sys.executable, ROOT / "benchmarks" / "run.py", *options], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    figures = json.loads(out.read_text())
    for name in ("scan", "local_map", "cycle_pruned", "cycle_unpruned", "trajectory"):
        assert set(figures[name]) == {"median_us", "p99_us", "n"}
        assert 0.0 < figures[name]["median_us"] <= figures[name]["p99_us"]
    assert figures["trial_realtime_factor"]["median"] > 0.0
    assert sum(figures["stages"].values()) == pytest.approx(1.0, abs=0.01)
    plans = figures["rollouts"]
    assert 0.0 < plans["coarse"]["median_us"] < plans["plan"]["median_us"] <= plans["plan"]["p99_us"]
    assert sum(plans["stages"].values()) == pytest.approx(1.0, abs=0.01)
    assert plans["plan_vs_vectorised"]["ratio"] > plans["coarse_vs_vectorised"]["ratio"] > 0.0
    assert plans["same_ends"]["n"] > 3000
    assert plans["same_ends"]["share"] > 0.999
    assert all(each["frames_per_s"] > 0 for each in figures["protocol"].values())
    assert all(0.0 < share < 1.0 for share in figures["driver_cpu"].values())
    assert set(figures["skipped"]) == {"ir-sim", "dynamic-window-approach"}
    skipped = {row["figure"] for row in figures["targets"] if row["met"] is None}
    assert len(skipped) == 3
    assert all(name in done.stdout for name in skipped)
