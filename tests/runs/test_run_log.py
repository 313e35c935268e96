"""What a run's log tells of the run."""

from collplan_ros.runs.run_log import PoseRow, RunLog


def test_a_run_that_ended_before_a_command_came_has_none():
    """As where the goal is refused at once."""
    assert RunLog(poses=[PoseRow(1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 5.0)]).commands == []
