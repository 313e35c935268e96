"""Studies small enough to be run in a test."""

import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import polars as pl

from collplan_study.main import main
from collplan_study.run.study_folder import ROWS

QUESTION = ["--worlds", "corridor,random:3", "--strategies", "harness,low_risk", "--map-periods", "0.2"]
GRID = [*QUESTION, "--trials", "2", "--seed", "7", "--set", "simulator.noise=0.5,1"]
N_TRIALS = 2 * 2 * 2 * 2
WALL_TIMES = ["plan_time_ms_p50", "plan_time_ms_p99", "wall_time_s"]
"""Columns in which two runs of one trial differ."""


def run(out: Path, *options: str) -> Path:
    assert main([*GRID, "--out", str(out), "--no-report", *options]) == 0
    return out


def resume(folder: Path, *options: str) -> Path:
    assert main(["--resume", str(folder), "--no-report", *options]) == 0
    return folder


def table(folder: Path) -> pl.DataFrame:
    return pl.read_parquet(folder / "trials.parquet").drop(WALL_TIMES)


def paths(folder: Path) -> pl.DataFrame:
    return pl.read_parquet(folder / "trajectories.parquet")


def same(folder: Path, other: Path) -> bool:
    return table(folder).equals(table(other)) and paths(folder).equals(paths(other))


def start(out: Path, arguments: Sequence[str]) -> subprocess.Popen:
    code = "import sys; from collplan_study.main import main; sys.exit(main())"
    return subprocess.Popen(
        [sys.executable, "-c", code, *arguments, "--no-report", "--out", str(out)], stderr=subprocess.DEVNULL
    )


def wait_for_rows(folder: Path, process: subprocess.Popen, count: int) -> None:
    deadline = time.monotonic() + 60.0
    while n_rows(folder) < count:
        assert process.poll() is None, "ended before it was killed"
        assert time.monotonic() < deadline
        time.sleep(0.005)


def n_rows(folder: Path) -> int:
    file = folder / ROWS
    return file.read_bytes().count(b"\n") if file.exists() else 0
