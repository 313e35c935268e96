"""Goals reached through the whole graph, in one process, and what its journals replay (simulated)."""

import os

import pytest

from collplan_core.parameters import Settings
from collplan_core.parameters.file import read_parameters, write_values
from collplan_core.warm_up import warm_up
from collplan_ros.bringup.main import run
from collplan_ros.bringup.options import parse
from collplan_ros.replay.main import main


@pytest.fixture
def through_the_graph(tmp_path, capsys):
    """The summary of one run of bringup, which is replayed to the last bit."""
    warm_up()

    def driven(world: str, strategy: str, seed: int = 0, *options: str) -> dict:
        asked = ["--world", world, "--strategy", strategy, "--seed", str(seed), "--no-pictures"]
        result = run(parse([*asked, "--out", str(tmp_path / "runs"), *options]))
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
def test_a_goal_is_reached_with_bounces_by_a_robot_of_twice_the_mass_which_learns_and_tells_its_load(
    through_the_graph, tmp_path
):
    heavy, lab = tmp_path / "heavy.yaml", tmp_path / "lab.yaml"
    write_values({"simulator.mass_ratio": 2.0}, heavy)
    summary = through_the_graph("serpentine:2", "bounce", 0, "--params", str(heavy))
    assert summary["reached"]
    drive = summary["drive"]
    assert drive["max_acceleration"] == pytest.approx(0.75, rel=0.06)
    assert drive["max_acceleration.low"] < drive["max_acceleration.learnt"] < drive["max_acceleration.high"]
    for words in ("drives like 0.7", "set to 1.5; ", " with restitution 0."):
        assert words in drive["in_words"]
    lab.write_text("/**:\n  ros__parameters:\n" + "".join(f"    {line}\n" for line in drive["parameters"]))
    kept = Settings().with_values(read_parameters(lab))
    assert kept.robot.max_acceleration == pytest.approx(drive["max_acceleration"], rel=1e-3)


@pytest.mark.soak
def test_one_core_is_enough(through_the_graph):
    all_cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(all_cores)})
    try:
        assert through_the_graph("corridor", "harness")["reached"]
    finally:
        os.sched_setaffinity(0, all_cores)
