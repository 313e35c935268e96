import pytest


@pytest.fixture
def serial_robot(ros, tmp_path):
    """Makes a robot behind a pseudo-terminal that commands reach."""
    from serial_robot import SerialRobot

    def made(**parameters):
        robot = SerialRobot(ros, tmp_path, **parameters)
        robot.ready()
        return robot

    return made
