"""Goals reached through the whole graph, in one process, and what its journals replay (simulated)."""

import os
from collections import Counter

import pytest

from collplan_core.command import BOUNDARY_FOLLOWING, FLOW_THROUGH, FREE_SPACE
from collplan_core.strategies import PAPER_WEIGHTS, TIME_TO_GOAL
from collplan_core.warm_up import warm_up
from collplan_core.worlds import arena_names
from collplan_ros.bringup.main import run
from collplan_ros.bringup.options import parse
from collplan_ros.replay.main import main


@pytest.fixture
def through_the_graph(tmp_path, capsys):
    """The summary of one run of bringup, which is replayed to the last bit."""
    warm_up()

    def driven(world: str, strategy: str, seed: int = 0, *options: str) -> dict:
        asked = ["--world", world, "--strategy", strategy, "--seed", str(seed), "--out", str(tmp_path), "--no-pictures"]
        result = run(parse([*asked, *options]))
        before = {path.name: path.stat().st_mtime_ns for path in result.folder.iterdir()}
        capsys.readouterr()
        code = main([str(result.folder)])
        planner, controller = capsys.readouterr().out.splitlines()
        assert code == 0, f"{result.folder}\n{planner}\n{controller}"
        assert before == {path.name: path.stat().st_mtime_ns for path in result.folder.iterdir()}
        assert "0" not in (planner.split()[1], controller.split()[1])
        return {"where": (world, strategy, seed), **result.summary}

    return driven


@pytest.mark.timeout(300)
def test_a_goal_is_reached_with_a_bounce_and_the_run_is_replayed_to_the_last_bit(through_the_graph):
    assert through_the_graph("u:17", "bounce", 1)["reached"]


@pytest.mark.soak
def test_every_strategy_reaches_the_goal_of_every_arena_and_every_maneuver_is_engaged(through_the_graph):
    maneuvers: Counter[str] = Counter()
    missed = []
    for world in arena_names():
        for strategy in (*PAPER_WEIGHTS, *TIME_TO_GOAL):
            summary = through_the_graph(world, strategy)
            maneuvers.update(summary["maneuvers"])
            missed += [] if summary["reached"] else [(summary["where"], summary["outcome"])]
    assert missed == []
    for seed in range(3, 33):
        # of 20 trials in the corridor with it, 6 follow a boundary and 2 flow through
        if not set(maneuvers) >= {FREE_SPACE, BOUNDARY_FOLLOWING, FLOW_THROUGH}:
            maneuvers.update(through_the_graph("corridor", "harness", seed)["maneuvers"])
    assert {FREE_SPACE, BOUNDARY_FOLLOWING, FLOW_THROUGH} <= set(maneuvers), maneuvers


@pytest.mark.soak
def test_one_core_is_enough(through_the_graph):
    all_cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(all_cores)})
    try:
        assert through_the_graph("corridor", "harness")["reached"]
    finally:
        os.sched_setaffinity(0, all_cores)
