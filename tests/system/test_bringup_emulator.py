"""The whole graph over serial bytes: bringup with the emulated firmware, and a robot that cannot be reached."""

import io
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from collplan_core.parameters import Settings
from collplan_core.parameters.file import write_parameters
from collplan_ros.bringup import driving, preparation
from collplan_ros.bringup.ending import StartError
from collplan_ros.bringup.main import run
from collplan_ros.bringup.options import Options, robot_kind
from collplan_ros.bringup.preparation import prepare
from collplan_ros.bringup.progress import Progress


def with_emulator(folder: Path, faults: str) -> tuple[int, str, dict]:
    file, out = folder / "emulator.yaml", folder / "runs"
    file.write_text(f"/**:\n  ros__parameters:\n    emulator.faults: {faults}\n")
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
    slow.write_text("/**:\n  ros__parameters:\n    robot: {max_speed: 0.2}\n")
    other.write_text("/**:\n  ros__parameters:\n    robot: {radius: 0.1}\n")
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
