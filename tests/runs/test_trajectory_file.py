"""The rows of trajectory.csv."""

import csv

import pytest

from collplan_ros.runs.run_log import PoseRow, RunLog, SentCommand, SentManeuver, SentReference
from collplan_ros.runs.trajectory_file import COLUMNS, write_trajectory
from made_runs import EPOCH


def test_the_trajectory_worked_by_hand(tmp_path):
    log = RunLog(
        poses=[
            PoseRow(EPOCH, 0.0, 0.0, 0.0, 0.0, 0.0, 77.0),
            PoseRow(EPOCH + 0.5, 0.4, 1.0, 0.1, 0.8, 2.0, 77.5),
        ],
        sent_commands=[SentCommand(77.1, 0.3, -0.1, 0.2), SentCommand(77.6, 9.0, 9.0, 9.0)],
        sent_maneuvers=[SentManeuver(77.101, "free_space")],
        sent_references=[SentReference(77.101, 0.5, 1.0)],
    )
    write_trajectory(tmp_path / "trajectory.csv", log)
    first, second = csv.DictReader((tmp_path / "trajectory.csv").open())
    assert tuple(first) == COLUMNS
    assert (first["cmd_vx"], first["ref_x"], first["maneuver"]) == ("nan", "nan", "stopped")
    assert (float(first["t"]), second["maneuver"]) == (pytest.approx(-0.1, abs=1e-6), "free_space")
    assert [float(second[key]) for key in COLUMNS[:-1]] == pytest.approx(
        [0.4, 0.4, 1.0, 0.1, 0.8, 2.0, 0.3, -0.1, 0.2, 0.5, 1.0], abs=1e-6
    )
