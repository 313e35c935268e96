"""A robot is called simulated, emulated or real only where there is no doubt."""

from collplan_ros.view.scene import EMULATED, REAL, SIMULATED, UNKNOWN, which_robot

SIMULATOR = {"simulator.world": "corridor", "robot.radius": 0.09}
SERIAL = {"driver.port": "/dev/ttyUSB0", "robot.radius": 0.09}
DRIVER = {"driver.port": "/tmp/omnipuck", "robot.radius": 0.09}
FIRMWARE = {"emulator.link": "/tmp/omnipuck", "simulator.world": "corridor"}
PLANNER = {"planner.strategy": "bounce"}


def test_which_robot():
    for known, silent, expected in (
        ({"/robot": SIMULATOR, "/p": PLANNER}, ["/q"], SIMULATED),
        ({"/robot": DRIVER, "/f": FIRMWARE}, [], EMULATED),
        ({"/robot": SERIAL, "/p": PLANNER}, [], REAL),
        ({"/robot": SERIAL}, ["/firmware_emulator"], UNKNOWN),
        ({"/robot": SERIAL}, ["/a_lidar", "/view_node"], REAL),
        ({"/robot": SERIAL, "/f": FIRMWARE}, [], UNKNOWN),  # which may be at the port by another name
        ({"/robot": DRIVER}, [], UNKNOWN),
        ({"/robot": {"driver.port": "/dev/pts/3"}}, [], UNKNOWN),
        ({"/robot": {"my.own": 1}}, [], UNKNOWN),
        ({"/robot": SIMULATOR, "/other": SERIAL}, [], UNKNOWN),  # two robots in a namespace
        ({"/robot": {"driver.port": 3}}, [], UNKNOWN),
        ({}, [], UNKNOWN),
    ):
        assert which_robot("/robot", known, [*known, *silent]) == expected, (known, silent)
    ended = {"/robot": SERIAL, "/simulator_node": SIMULATOR}
    assert which_robot("/robot", ended, ["/robot"]) == REAL
