"""The emulated firmware as a node: its pseudo-terminal, and what it refuses at the start."""

import os

import pytest
from geometry_msgs.msg import PoseStamped

from collplan_core.parameters.spec import ParameterError
from collplan_ros.messages.qos import POSE_SUBSCRIBED
from omnipuck_sim.emulator.firmware_emulator import FirmwareEmulator


def test_its_path_leads_to_a_terminal_that_speaks(ros, tmp_path):
    node = ros.make(FirmwareEmulator, {"emulator.link": str(tmp_path / "line")})
    device = os.open(tmp_path / "line", os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY)
    assert os.isatty(device)
    poses = ros.listen(PoseStamped, "mocap/pose", POSE_SUBSCRIBED)
    assert ros.wait_until(lambda: len(poses) > 20)
    assert os.read(device, 4096).count(b"\0") > 10
    os.close(device)
    node.destroy_node()
    assert not (tmp_path / "line").is_symlink()


def test_a_link_of_one_that_was_killed_is_taken_over_and_a_file_is_not(ros, tmp_path):
    (tmp_path / "line").symlink_to("/dev/pts/no_more")
    ros.make(FirmwareEmulator, {"emulator.link": str(tmp_path / "line")})
    (tmp_path / "file").write_text("precious")
    with pytest.raises(FileExistsError, match=r"emulator\.link"):
        ros.make(FirmwareEmulator, {"emulator.link": str(tmp_path / "file")})
    assert (tmp_path / "file").read_text() == "precious"


def test_parameters_it_cannot_do_are_refused_at_the_start(ros, tmp_path):
    wrong = {
        "simulator.speed_factor": 2.0,
        "emulator.faults": "flipped=1.5",
        "kinematics.wheel_angles": [0.0, 0.0, 0.0],
    }
    for key, value in wrong.items():
        with pytest.raises(ParameterError, match=key):
            ros.make(FirmwareEmulator, {"emulator.link": str(tmp_path / "line"), key: value})
