"""A LIDAR that does not see all around, and a goal behind the robot with a wall before it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings
from collplan_core.scan import Scan
from collplan_core.worlds import parse_world
from omnipuck_sim.trial import TrialNodes, run_trial

WALL = [[2.0, 0.9], [2.1, 0.9], [2.1, 2.1], [2.0, 2.1]]
ROOM = parse_world(
    {"name": "behind", "bounds": [0, 0, 5, 3], "polygons": [WALL], "start": [3.5, 1.5], "goal": [1.0, 1.5]}, "behind"
)


def trial(degrees, strategy, nodes_class=TrialNodes, **more):
    span = math.radians(degrees)
    values = {"planner.strategy": strategy, "lidar.angle_min": -0.5 * span, "lidar.angle_span": span, **more}
    settings = Settings().with_values({"lidar.n_beams": 180, "limits.lost_beams": 0.9, **values})
    result = run_trial(ROOM, settings, 1, nodes_class=nodes_class)
    return result, max((float(-hit.velocity_before @ hit.normal) for hit in result.impacts), default=0.0)


@pytest.mark.parametrize("degrees", [180, 70])
def test_a_base_that_turns_arrives_without_a_touch(degrees):
    result, hardest = trial(degrees, "avoid", **{"controller.turns_to_look": True})
    assert result.outcome == REACHED
    assert hardest <= 0.1


def test_one_that_does_not_turn_drives_slowly_where_it_has_not_looked():
    result, hardest = trial(180, "avoid", **{"trial.timeout": 5.0})
    times, places = result.trajectory[:, 0], result.trajectory[:, 1]
    farthest_back = (places <= np.minimum.accumulate(places)) & (places < ROOM.start[0] - 0.03)
    assert -np.gradient(places, times)[farthest_back].min(initial=0.0) < 0.2
    assert hardest <= 0.13
    assert "sees 180 of 360 degrees, controller.turns_to_look is false" in result.reason


class Posts(TrialNodes):
    """Nodes whose LIDAR sees four posts of the robot."""

    def _take_scan(self, scan: Scan) -> None:
        quarter = np.remainder(scan.angles, 0.5 * np.pi)
        post = np.minimum(quarter, 0.5 * np.pi - quarter) < 0.1
        super()._take_scan(replace(scan, ranges=np.where(post, 0.07, scan.ranges)))


def test_a_scan_that_shows_the_robot_s_posts_is_named_and_with_a_mask_it_drives():
    masked = tuple(np.array([(k - 0.12, k + 0.12) for k in 0.5 * np.pi * np.arange(4)]).ravel().tolist())
    result, _ = trial(360, "harness", Posts, **{"trial.timeout": 3.0})
    assert result.outcome != REACHED
    assert "inside the robot" in result.reason
    assert "scan.masked_angles" in result.reason
    result, _ = trial(360, "harness", Posts, **{"scan.masked_angles": masked})
    assert result.outcome == REACHED
