"""Command lines that bringup prints: examples, and the one that repeats a run."""

import shlex
from pathlib import Path

import numpy as np
import pytest

from collplan_core.command_line import as_called
from collplan_ros.bringup.options import Options, parse


@pytest.mark.parametrize(
    ("typed", "printed"),
    [
        (".venv/bin/bringup", ".venv/bin/bringup"),
        ("/opt/ros/lib/bringup", "/opt/ros/lib/bringup"),
        ("main.py", "THERE/bringup"),
        (".venv/bin/study", "THERE/bringup"),
    ],
)
def test_a_command_printed_works_from_where_the_user_stands(tmp_path, monkeypatch, typed, printed):
    monkeypatch.setattr("sys.argv", [typed])
    monkeypatch.setattr("sys.executable", str(tmp_path / "python3"))
    assert as_called("bringup") == (typed if typed == printed else "bringup")
    (tmp_path / "bringup").touch()
    assert as_called("bringup") == printed.replace("THERE", str(tmp_path))


def test_every_example_of_the_help_starts_the_program_as_it_was_called(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", [".venv/bin/bringup", "--help"])
    with pytest.raises(SystemExit, match="0"):
        parse()
    lines = capsys.readouterr().out.partition("examples:")[2].partition("\n\n")[0].splitlines()[1:]
    assert len(lines) > 5
    assert all(line.startswith(("  .venv/bin/bringup", "      ")) for line in lines)


@pytest.mark.parametrize("goal", [(2.0, 0.4), (-1e-05, -3.0)])
@pytest.mark.parametrize("network", [None, "subnet"])
@pytest.mark.parametrize("namespace", ["/", "/lab/robot1"])
def test_the_line_that_repeats_a_run_gives_robot_goal_and_parameters(monkeypatch, goal, network, namespace):
    monkeypatch.setattr("sys.argv", [".venv/bin/bringup", "--seed", "3"])
    first = Options(
        robot="serial:/dev/my robot", goal=goal, network=network, timeout=9.0, max_speed=0.9, namespace=namespace
    )
    program, *arguments = shlex.split(first.repeat(np.array(goal), Path("the runs/latest/parameters.yaml")))
    again = parse(arguments)
    assert (program, again.robot, again.goal, again.network) == (".venv/bin/bringup", first.robot, goal, network)
    assert (again.max_speed, again.namespace) == (first.max_speed, namespace)
    assert again.params == Path("the runs/latest/parameters.yaml")


def test_a_goal_is_two_numbers_with_or_without_a_comma(capsys):
    assert parse(["--goal", "1,-2"]).goal == parse(["--goal", "1", "-2"]).goal == (1.0, -2.0)
    for wrong in (["1"], ["1", "2", "3"], ["a,b"]):
        with pytest.raises(SystemExit, match="2"):
            parse(["--goal", *wrong])
        assert f"--goal: got {' '.join(wrong)}, expected two numbers" in capsys.readouterr().err


def test_a_namespace_is_given_with_or_without_its_slash():
    assert parse([]).namespace == "/"
    assert parse(["--namespace", "robot1"]).namespace == parse(["--namespace", "/robot1"]).namespace == "/robot1"


@pytest.mark.parametrize("namespace", ["robot 1", "1st", "robot1/", "/lab//robot1", "robot-1", "//robot1"])
def test_a_namespace_that_ros_does_not_take_is_refused(capsys, namespace):
    with pytest.raises(SystemExit, match="2"):
        parse(["--namespace", namespace])
    assert f"namespace: got {namespace!r}, expected letters, digits and _" in capsys.readouterr().err


def test_the_line_that_repeats_a_run_says_whose_scans_and_no_world_where_there_was_none(monkeypatch):
    monkeypatch.setattr("sys.argv", [".venv/bin/bringup"])
    real = Options(robot="serial:/dev/x", goal=(1.0, 0.5), network="subnet", scan="real")
    _, *arguments = shlex.split(real.repeat(np.array(real.goal), Path("parameters.yaml")))
    again = parse(arguments)
    assert (again.scan, again.world, again.robot) == ("real", None, real.robot)
    assert "--scan" not in Options(goal=(1.0, 0.5)).repeat(np.array([1.0, 0.5]), Path("parameters.yaml"))
