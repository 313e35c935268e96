"""The driver against the emulated firmware: stopping in time, reconnecting, and what it says in trouble."""

import pytest

from collplan_core.params import Settings

LONGEST = Settings().limits.command_age + 1.0 / Settings().controller.rate
STEP = 1.0 / Settings().simulator.physics_rate


def stop_ages(robot, runs: int) -> list[float]:
    """Age of the last command at each stop of the wheels, by the emulator's clock; runs it stalled in are left out."""
    ages = []
    while len(ages) < runs:
        robot.drive_until(lambda: robot.speed > 0.1, x=0.4)
        before, lost = robot.stops, robot.emulator._room.lost
        robot.until(lambda before=before: robot.stops > before)
        if robot.emulator._room.lost == lost:
            ages.append(robot.stop_age)
        if robot.odometry[-1].pose.pose.position.x > 15.0:
            robot.call("reset")
    return ages


def test_silence_stops_the_wheels_in_time(serial_robot):
    robot = serial_robot()
    assert max(stop_ages(robot, 20)) <= LONGEST + STEP


@pytest.mark.soak
@pytest.mark.timeout(1800)
def test_silence_stops_the_wheels_in_time_a_thousand_times(serial_robot):
    robot = serial_robot()
    assert max(stop_ages(robot, 1000)) <= LONGEST + STEP
