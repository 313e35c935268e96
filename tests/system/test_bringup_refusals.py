"""What bringup makes of its options and refuses before anything starts, and how it ends its processes."""

import io
import json
import os
import re
import socket
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from bringup_process import wait_for
from rclpy.context import Context
from rclpy.node import Node

from collplan_core.parameters import Settings
from collplan_core.parameters.file import write_parameters
from collplan_ros.bringup import driving, preparation, processes
from collplan_ros.bringup.ending import NodeDied, StartError
from collplan_ros.bringup.main import main, run
from collplan_ros.bringup.options import Options, robot_kind
from collplan_ros.bringup.preparation import prepare
from collplan_ros.bringup.processes import NodeLogs, Processes
from collplan_ros.bringup.progress import Progress
from collplan_ros.node_kit.reachability import RANGE, environment_set

WORLD = "bounds: [0, 0, 2, 1]\nwalled: true\npolygons:\n  - [[0.8, 0], [1.0, 0], [1.0, 1], [0.8, 1]]\n"


def written(path: Path, group: str) -> str:
    path.write_text(f"/**:\n  ros__parameters:\n    {group}\n")
    return str(path)


def test_what_cannot_be_done_is_one_line_and_exit_code_2_before_anything_starts(tmp_path, capsys):
    (tmp_path / "split.yaml").write_text(WORLD + "start: [0.3, 0.5]\n")
    on_start = "start: [0.3, 0.5]\ngoal: [0.6, 0.5]\nmovers:\n  - {radius: 0.1, way: [[0.4, 0.5]], speed: 1}\n"
    (tmp_path / "moved.yaml").write_text(WORLD + on_start)
    (tmp_path / "file").write_text("")
    split = ["--world", str(tmp_path / "split.yaml")]
    known = written(tmp_path / "c.yaml", "{trial: {known_map: true}}")
    real = ["--robot", "serial:/dev/null", "--world", "corridor", "--goal", "2.0", "0.4", "--network", "local"]
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        for arguments, expected in (
            (["--strategy", "fast"], "planner.strategy: got 'fast', expected one of harness"),
            ([*split, "--goal", "1.5", "0.5"], "cannot be reached"),
            (["--world", str(tmp_path / "moved.yaml")], "[0.4, 0.5] is 0.10 m from the robot's start"),
            (["--params", "missing.yaml"], "missing.yaml"),
            (["--strategy", "bounce", "--params", known], "trial.known_map: got True, expected False"),
            (["--view", "--params", written(tmp_path / "d.yaml", f"view: {{port: {port}}}")], f"127.0.0.1:{port}"),
            ([*real, "--again"], "--again: got --robot serial:/dev/null"),
        ):
            assert main([*arguments, "--out", str(tmp_path / "runs")]) == 2, arguments
            error = capsys.readouterr().err
            assert expected in error
            assert error.startswith("bringup: ")
            assert len(error.splitlines()) == 1, error
    assert not (tmp_path / "runs").exists()
    assert main(["--out", str(tmp_path / "file")]) == 2
    assert "is a file" in capsys.readouterr().err
    for arguments, expected in (
        (["--robot", "tank"], "--robot"),
        (["--check", "--yes"], "--check: no longer an option, inspect --live 60 takes its place"),
    ):
        with pytest.raises(SystemExit, match="2"):
            main(arguments)
        assert expected in capsys.readouterr().err


def test_a_real_lidar_needs_no_lidar_node_and_for_a_real_robot_no_world(tmp_path, monkeypatch):
    monkeypatch.setattr(preparation, "find_executable", lambda name: name)
    real = Options(robot="serial:/dev/null", network="subnet", goal=(1.0, 0.5), scan="real")
    prepared = prepare(real)
    assert "lidar_node" not in prepared.programs
    assert (prepared.world.name, prepared.settings.lidar.world, prepared.settings.simulator.world) == ("unknown",) * 3
    with pytest.raises(StartError, match="missing: --world"):
        prepare(replace(real, scan="sim"))
    simulated = prepare(Options(scan="real"))
    assert (simulated.world.name, "lidar_node" in simulated.programs) == ("corridor", False)
    # a world of the parameter file was another run's
    written(tmp_path / "old.yaml", "lidar.world: slalom")
    assert prepare(replace(real, params=tmp_path / "old.yaml")).world.name == "unknown"
    assert prepare(replace(real, world="slalom")).world.name == "slalom"
    # a base stops at its goal, unless something says otherwise
    passing = tmp_path / "passing.yaml"
    written(passing, "planner.stop_at_goal: false")
    base = replace(real, robot="base:/cmd_vel")
    assert prepare(base).settings.planner.stop_at_goal
    for other in (replace(base, params=passing), real, Options()):
        assert not prepare(other).settings.planner.stop_at_goal


def test_options_outrank_the_parameter_file_and_the_file_the_defaults(tmp_path):
    file = tmp_path / "mine.yaml"
    written(file, "planner: {strategy: low_risk}\n    simulator: {seed: 5, world: slalom}")
    prepared = prepare(Options(params=file, seed=7))
    assert prepared.settings.planner.strategy == "low_risk"
    assert (prepared.settings.simulator.seed, prepared.world.name) == (7, "slalom")
    assert prepared.network == "local"


def test_poses_that_repeat_are_accepted_where_it_simulates_without_noise(tmp_path):
    for simulator, mocap, accepted in (
        ({"mocap_noise": 0.0}, {}, True),
        ({"noise": 0.0}, {"accept_frozen": False}, False),
    ):
        path = tmp_path / "parameters.yaml"
        path.write_text(json.dumps({"/**": {"ros__parameters": {"simulator": simulator, "mocap": mocap}}}))
        assert prepare(Options(params=path)).settings.mocap.accept_frozen is accepted, (simulator, mocap)


def test_a_second_graph_of_a_robot_that_is_not_simulated_is_refused(tmp_path, capsys):
    robot = ["--robot", "base:/cmd_vel", "--goal", "1", "1", "--scan", "real", "--network", "local"]
    for by_hand, namespace in ((True, "/"), (False, "/robot1")):
        context = Context()
        with environment_set({RANGE: "LOCALHOST"} if by_hand else {}):
            context.init()
        other = Node("planner_node", context=context, namespace=namespace)
        try:
            assert main([*robot, "--out", str(tmp_path), "--namespace", namespace]) == 2
        finally:
            other.destroy_node()
            context.shutdown()
        assert f"planner_node already in domain {os.environ['ROS_DOMAIN_ID']}" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_node_that_ignores_sigterm_is_killed_the_first_one_goes_first_and_a_device_last(tmp_path, monkeypatch):
    monkeypatch.setattr(processes, "STOP_PATIENCE", 1.0)
    program = "import signal, sys, time; signal.signal(signal.SIGTERM, {}); print('up', flush=True); time.sleep(60)"
    stubborn, polite = program.format("signal.SIG_IGN"), program.format("lambda *_: sys.exit(print(time.time()))")
    nodes = Processes(NodeLogs(tmp_path))
    for name, code in (("device", polite), ("other", polite), ("stubborn", stubborn), ("controller", polite)):
        nodes.start(name, [sys.executable, "-c", code])
    wait_for(lambda: all((tmp_path / f"{name}.log").read_text() for name in nodes.pids))
    nodes.stop(["controller"])
    assert nodes.stop_all(("device",)) == ["stubborn"]
    orderly = ("other", "controller", "device")
    ended = {name: float((tmp_path / f"{name}.log").read_text().split()[1]) for name in orderly}
    assert sorted(ended, key=ended.__getitem__) == ["controller", "other", "device"]
    with pytest.raises(NodeDied, match=r"^stubborn was killed by SIGKILL$"):
        nodes.check([].append, dict.fromkeys(orderly, ""))


# ---- robots over serial bytes


def with_emulator(folder: Path, faults: str) -> tuple[int, str, dict]:
    file, out = folder / "emulator.yaml", folder / "runs"
    written(file, f"emulator.faults: {faults}")
    options = ["--no-pictures", "--robot", "emulator", "--params", str(file), "--out", str(out)]
    command = [sys.executable, "-m", "collplan_ros.bringup.main", *options]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=110, check=False)
    text, summary = ended.stdout + ended.stderr, out / "latest" / "summary.json"
    assert summary.exists(), f"exit code {ended.returncode}: {text}"
    return ended.returncode, text, json.loads(summary.read_text())


@pytest.mark.soak
@pytest.mark.timeout(300)
def test_the_goal_is_reached_over_serial_bytes_with_one_in_a_hundred_corrupted(tmp_path):
    code, text, summary = with_emulator(tmp_path, "flipped=0.01")
    assert code == 0, text
    assert (summary["reached"], summary["simulated"]) == (True, True)
    assert summary["path_length_source"] == "ground_truth"
    assert not (tmp_path / "runs" / "latest" / "serial").is_symlink()
    logs = "".join(log.read_text() for log in (tmp_path / "runs" / "latest" / "log").iterdir())
    assert "connected" in logs
    assert "Traceback" not in logs


def test_a_serial_robot_that_is_not_there_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(preparation, "NODES", ())
    monkeypatch.setattr(driving, "LINK_PATIENCE", 0.5)
    said = {"world": "corridor", "goal": (1.0, 0.3), "network": "local"}
    said_ = io.StringIO()
    result = run(Options(robot="serial:/dev/no_such_robot@57600", out=tmp_path / "runs", **said), Progress(said_))
    assert (result.exit_code, result.summary["simulated"]) == (3, False)
    assert result.message.startswith("driver_node: /dev/no_such_robot: ")
    # how fast it drives is its first line
    assert said_.getvalue().startswith("drives at 0.3 m/s")


def test_a_serial_robot_sets_device_rate_and_network():
    robot = robot_kind("serial:/dev/ttyACM1@57600")
    assert robot.values == {"driver.port": "/dev/ttyACM1", "driver.baud": 57600}
    assert (robot.simulated, robot.nodes) == (False, ("driver_node",))
    assert robot_kind("serial:/dev/serial/by-id/usb@odd@9600").values["driver.port"] == "/dev/serial/by-id/usb@odd"
    prepared = prepare(Options(robot="serial:/dev/ttyACM1", **SAID))
    assert (prepared.settings.driver.port, prepared.network) == ("/dev/ttyACM1", "subnet")


SAID = {"world": "corridor", "goal": (1.0, 0.3), "network": "subnet"}


def test_where_a_real_robot_is_and_goes_and_who_may_command_it_has_to_be_said(tmp_path):
    file = tmp_path / "last.yaml"
    file.write_text("/**:\n  ros__parameters:\n    lidar: {world: corridor}\n    simulator: {world: corridor}\n")
    for missing in (["goal"], ["world", "network"], list(SAID)):
        said = {key: value for key, value in SAID.items() if key not in missing}
        with pytest.raises(StartError, match="missing: --") as error:
            prepare(Options(robot="serial:/dev/x", params=file, **said))
        assert re.findall(r"--(\w+)", str(error.value).partition("missing: ")[2]) == missing


def test_a_real_robot_is_slow_unless_the_command_line_says_otherwise_and_it_is_said_why(tmp_path):
    fast, slow, other = (tmp_path / f"{name}.yaml" for name in ("fast", "slow", "other"))
    write_parameters(Settings(), fast)  # as a simulated run leaves it
    written(slow, "robot: {max_speed: 0.2}")
    written(other, "robot: {radius: 0.1}")
    for given, speed, source in (
        ({"params": other}, 0.3, "no --max-speed"),
        ({"params": fast}, 0.3, f"robot.max_speed 1.2 of {fast}"),
        ({"params": slow}, 0.2, f"robot.max_speed of {slow}"),
        ({"params": fast, "max_speed": 0.5}, 0.5, "--max-speed"),
        ({"max_speed": 0.1}, 0.1, "--max-speed"),
    ):
        prepared = prepare(Options(robot="serial:/dev/x", **SAID, **given))
        assert prepared.settings.robot.max_speed == speed
        assert f"{speed:g} m/s" in prepared.speed
        assert source in prepared.speed
    for robot in ("sim", "emulator"):
        prepared = prepare(Options(robot=robot))
        assert prepared.network == "local"
        assert (prepared.settings.robot.max_speed, prepared.speed) == (Settings().robot.max_speed, "")


def test_a_robot_that_is_none_is_refused():
    for spec in ("serial:", "serial:/dev/ttyUSB0@fast", "sim:x"):
        with pytest.raises(StartError, match="expected one of sim, emulator"):
            robot_kind(spec)
