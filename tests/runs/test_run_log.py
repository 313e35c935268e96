"""What a run's log tells of the run."""

import pytest

from collplan_ros.runs.run_log import PoseRow, RunLog, SentCommand


def test_a_run_that_ended_before_a_command_came_has_none():
    """As where the goal is refused at once."""
    assert RunLog(poses=[PoseRow(1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 5.0)]).commands == []


@pytest.mark.parametrize("pace", [0.1, 1.0, 20.0])
def test_what_was_sent_between_two_poses_is_between_their_stamps_at_any_pace_of_a_simulation(pace):
    poses = [PoseRow(100.0 + 0.1 * k, 0.0, 0.0, 0.0, 0.0, 0.0, 5.0 + 0.1 * k / pace) for k in range(3)]
    log = RunLog(poses=poses, sent_commands=[SentCommand(5.0 + 0.14 / pace, 1.0, 0.0, 0.0)], pace=pace)
    log.reached_sent = 5.0 + 0.16 / pace
    assert log.commands[0].stamp == pytest.approx(100.14)
    assert (log.time_zero, log.arrival) == pytest.approx((100.14, 100.16))
