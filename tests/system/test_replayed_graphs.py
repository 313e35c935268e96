"""Recordings of the whole graph, replayed."""

from pathlib import Path

import pytest

from collplan_core.strategies import PAPER_WEIGHTS, TIME_TO_GOAL
from collplan_core.warm_up import warm_up
from collplan_ros.bringup.main import run
from collplan_ros.bringup.options import parse
from collplan_ros.replay.main import main

STRATEGIES = (*PAPER_WEIGHTS, *TIME_TO_GOAL)
WORLDS = ("corridor", "u:17", "serpentine:2", "random:7")
RUNS = 4
"""So often a run is tried on a machine that stalls: where it stalls for long, the robot stands as it should."""
FEW = 8
"""Plans of a run that did not get far."""


@pytest.fixture
def replayed(tmp_path, capsys):
    """Number of plans of a run of bringup that was replayed to the last bit, however the run has ended."""

    def replayed(world: str, strategy: str, seed: int) -> int:
        asked = ["--world", world, "--strategy", strategy, "--seed", str(seed), "--timeout", "6"]
        folder = run(parse([*asked, "--out", str(tmp_path), "--no-pictures"])).folder
        before = times_of(folder)
        capsys.readouterr()
        code = main([str(folder)])
        planner, controller = capsys.readouterr().out.splitlines()
        assert code == 0, f"{folder}\n{planner}\n{controller}"
        assert times_of(folder) == before
        assert controller.split()[1] != "0"
        return int(planner.split()[1])

    warm_up()
    return replayed


def times_of(folder: Path) -> dict[str, int]:
    """When each file was written last."""
    return {path.name: path.stat().st_mtime_ns for path in folder.iterdir()}


@pytest.mark.timeout(300)
def test_a_run_of_bringup_is_replayed_to_the_last_bit(replayed):
    assert any(replayed("u:17", "bounce", 1) > FEW for _ in range(RUNS))


@pytest.mark.soak
@pytest.mark.timeout(2400)
def test_twenty_runs_of_bringup_are_replayed_to_the_last_bit(replayed):
    plans = [replayed(WORLDS[seed % 4], STRATEGIES[seed % 7], seed) for seed in range(20)]
    assert sum(count > FEW for count in plans) >= 15, plans
