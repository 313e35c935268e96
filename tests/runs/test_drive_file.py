"""The parameter file of `bringup --keep`: what is refused before a run, and what is written after it."""

import pytest

from collplan_core.parameters import Settings
from collplan_core.parameters.file import read_parameters, write_values
from collplan_ros.bringup.drive_file import check_keep, kept
from collplan_ros.bringup.failures import StartError

LEARNT = {
    **{"max_acceleration": 0.75, "max_acceleration.learnt": 0.75},
    **{"velocity_lag": 0.2, "velocity_lag.learnt": 0.2},
    **{"motion_delay": 0.0, "motion_delay.learnt": 0.004},
}


@pytest.mark.parametrize(
    ("name", "content", "learning", "says"),
    [
        ("lab.yaml", "robot: nonsense", "drive", "lab.yaml"),
        ("missing/lab.yaml", None, "drive", "missing is no folder"),
        ("lab.yaml", None, "off", "robot.learning is off, expected drive"),
    ],
)
def test_what_could_not_be_written_is_refused_before_the_run(tmp_path, name, content, learning, says):
    path = tmp_path / name
    if content is not None:
        path.write_text(content)
    with pytest.raises(StartError, match=says):
        check_keep(path, Settings().with_values({"robot.learning": learning}))


@pytest.mark.parametrize("there", [False, True])
def test_a_file_that_is_not_there_or_empty_is_made(tmp_path, there):
    path = tmp_path / "lab.yaml"
    if there:
        path.touch()
    check_keep(path, Settings())
    kept(path, LEARNT, Settings(), simulated=False)
    assert read_parameters(path) == {"robot.max_acceleration": 0.75, "robot.velocity_lag": 0.2}


def test_a_simulated_robot_stays_the_same_run_after_run(tmp_path):
    path, settings = tmp_path / "lab.yaml", Settings().with_values({"simulator.mass_ratio": 2.0})
    for _ in range(2):
        kept(path, LEARNT, settings, simulated=True)
        settings = settings.with_values(read_parameters(path))
        robot, simulator = settings.robot, settings.simulator
        assert robot.velocity_lag * simulator.mass_ratio == pytest.approx(0.2)
        assert robot.max_acceleration * simulator.acceleration_ratio / simulator.mass_ratio == pytest.approx(0.75)


def test_nothing_is_written_of_what_is_set_already_or_not_learnt(tmp_path):
    path = tmp_path / "lab.yaml"
    in_use = {"max_acceleration": 1.5, "velocity_lag": 0.1, "motion_delay": 0.0}
    for drive in ({}, in_use, {**in_use, "max_acceleration.learnt": 1.49}):
        assert "not written" in kept(path, drive, Settings(), simulated=True)
    assert not path.exists()


def test_a_file_in_which_somebody_writes_nonsense_during_the_run_stays_as_it_is(tmp_path):
    path = tmp_path / "lab.yaml"
    write_values({"robot.radius": 0.1}, path)
    path.write_text("robot: nonsense")
    assert "not written" in kept(path, LEARNT, Settings(), simulated=False)
    assert path.read_text() == "robot: nonsense"
