"""The rule of the bench with movers by hand, what is drawn, and the figures from rows."""

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_core.worlds import World
from collplan_core.worlds.movers import place_at
from collplan_core.worlds.route import clearance
from collplan_core.worlds.shapes import obstacle_at
from movers_bench import ALONE, MOVERS, figures, main
from movers_rule import REACTION, SEEN, STILL, share_in_view, speed_left
from movers_walks import crossing_of, read_walks
from movers_worlds import ASIDE, FAMILIES, RADII, SPEEDS, shortest_way, with_movers, world_of

ROBOT = Settings().robot
R = 0.12
TIMES = np.arange(0.0, 3.0, 0.01)
EMPTY = World("w", (), np.zeros((0, 3)), (-9.0, -9.0, 9.0, 9.0), walled=False)
CORNER = World(
    "w", (np.array([(1.0, 0.3), (1.6, 0.3), (1.6, 2.0), (1.0, 2.0)]),), np.zeros((0, 3)), EMPTY.bounds, False
)


def driven(speed: float) -> np.ndarray:
    """Along the x axis."""
    still = np.zeros_like(TIMES)
    return np.column_stack([TIMES, speed * TIMES, still, still + speed, still])


def walked(start, velocity) -> np.ndarray:
    places = np.asarray(start) + TIMES[:, None] * velocity
    return np.column_stack([places, np.tile(velocity, (len(TIMES), 1)), np.full(len(TIMES), R)])


def seen_from(time: float) -> np.ndarray:
    return np.heaviside(TIMES - time, 1.0)


def touch_of(trajectory, mover) -> tuple[float, float]:
    apart = mover[:, :2] - trajectory[:, 1:3]
    k = int(np.argmax(np.hypot(*apart.T) <= ROBOT.radius + R))
    assert k > 0
    return TIMES[k], float(trajectory[k, 3:5] @ apart[k]) / float(np.hypot(*apart[k]))


def left(world, trajectory, mover, in_view=None) -> float:
    in_view = share_in_view(world, trajectory[:, 1:3], mover[:, None], 0) if in_view is None else in_view
    return speed_left(trajectory, mover, in_view, *touch_of(trajectory, mover), ROBOT)


def test_a_mover_in_the_open_three_metres_away_is_not_too_close():
    assert left(EMPTY, driven(1.2), walked((3.0, 0.0), (-0.5, 0.0))) == 0.0
    # nor if it appears there
    appears = seen_from(0.05)
    assert left(EMPTY, driven(1.2), walked((3.0, 0.0), (-0.5, 0.0)), appears) <= STILL


def test_one_that_steps_out_close_before_a_fast_robot_is_too_close():
    speed, out = 1.2, 0.8
    mover = walked((speed * out + ROBOT.radius + R + 0.2, 0.0), (0.0, 0.0))
    appears = seen_from(out)
    assert left(EMPTY, driven(speed), mover, appears) == pytest.approx(speed)
    # 0.8 m before it, the same robot stops; at 0.3 m/s 0.2 m are enough
    far = walked((speed * out + ROBOT.radius + R + 1.0, 0.0), (0.0, 0.0))
    assert left(EMPTY, driven(speed), far, appears) <= STILL
    slow = walked((0.3 * out + ROBOT.radius + R + 0.2, 0.0), (0.0, 0.0))
    assert left(EMPTY, driven(0.3), slow, appears) <= STILL


def test_between_both_braking_leaves_some_speed():
    speed, out = 1.2, 0.8
    # 0.3 m pass in the reaction; of the 0.3 m left the lag takes some, and sqrt(1.44 - 2 * 1.5 * 0.3) = 0.73
    mover = walked((speed * (out + REACTION) + ROBOT.radius + R + 0.3, 0.0), (0.0, 0.0))
    assert left(EMPTY, driven(speed), mover, seen_from(out - 0.005)) == pytest.approx(0.74, abs=0.05)


def test_one_that_sets_out_or_turns_is_not_known_before():
    mover = walked((1.2, 0.5), (0.0, 0.0))
    moves = TIMES > 0.7
    mover[moves, 1] -= (TIMES[moves] - 0.7) * 1.2
    mover[moves, 3] = -1.2
    assert left(EMPTY, driven(1.2), mover) > STILL
    assert left(EMPTY, driven(1.2), walked((1.2, 0.5 + 0.7 * 1.2), (0.0, -1.2))) == 0.0


def test_who_was_just_struck_cannot_stop():
    trajectory, mover = driven(0.6), walked((2.0, 0.0), (-0.3, 0.0))
    time, speed = touch_of(trajectory, mover)
    for ago, expected in ((0.2, speed), (1.5, 0.0)):
        assert speed_left(trajectory, mover, np.ones(len(TIMES)), time, speed, ROBOT, time - ago) == expected


def test_a_wall_hides_what_is_behind_it():
    places = np.array([(0.0, 0.0), (1.3, 0.0), (2.2, 0.0)])
    mover = np.tile([1.8, 0.6, 0.0, -0.5, R], (3, 1, 1))
    shares = share_in_view(CORNER, places, mover, 0)
    assert shares[0] < SEEN
    assert shares[2] == 1.0
    other = np.concatenate([mover, np.tile([2.0, 0.3, 0.0, 0.0, R], (3, 1, 1))], axis=1)
    assert share_in_view(CORNER, places, other, 0)[2] < 1.0  # the other one stands before it
    np.testing.assert_array_equal(share_in_view(EMPTY, places, mover, 0), 1.0)


def test_who_walks_behind_a_corner_comes_out_too_close_for_a_fast_robot_alone():
    # it comes down behind the corner and out into the robot's way
    for speed, too_close in ((1.2, True), (0.2, False)):
        arrives = 1.75 / speed
        mover = walked((1.8, 1.2 * min(arrives, 2.0)), (0.0, -1.2))
        trajectory = driven(speed)
        trajectory[:, 1] += 1.75 - speed * min(arrives, 2.0)
        assert (left(CORNER, trajectory, mover) > STILL) == too_close


@pytest.mark.parametrize("index", range(12))
def test_movers_are_drawn_anew_the_same_with_room_and_away_from_the_robot(index):
    world = world_of(index, 5)
    drawn = with_movers(world, index, 5)
    assert world.name.startswith(FAMILIES[index % 3])
    assert 1 <= len(drawn.movers) <= 3
    for mover, again in zip(drawn.movers, with_movers(world_of(index, 5), index, 5).movers, strict=True):
        np.testing.assert_array_equal(mover.way, again.way)
        assert SPEEDS[0] <= mover.speed <= SPEEDS[1]
        assert RADII[mover.kind][0] <= mover.radius <= RADII[mover.kind][1]
        assert clearance(world, mover.way[0], mover.reach) > -1e-4
        assert np.hypot(*(mover.way[0] - world.start)) > ASIDE - 0.05
    way = shortest_way(world)
    assert not any(obstacle_at(world, place) for place in way)
    assert np.hypot(*np.diff(way, axis=0).T).max() < 0.08


def row(index, strategy, moving, outcome="reached", time=2.0, touches=()):
    touches = [{"time": 1.0, "mover": 0, "speed": speed, "left": left} for speed, left in touches]
    task = [index, 1, strategy, MOVERS if moving else ALONE]
    return {"task": task, "outcome": outcome, "time": time, "touches": touches}


def test_the_figures_of_rows_by_hand():
    rows = [
        row(0, "avoid", True, time=3.0, touches=[(0.5, 0.0), (0.6, 0.6)]),  # a stop would have saved the first touch
        row(0, "avoid", False),
        row(1, "avoid", True, touches=[(0.9, 0.4), (0.05, 0.0)]),
        row(1, "avoid", False),
        row(2, "avoid", True, "stuck", 30.0, touches=[(-0.3, 0.0)]),
        row(2, "avoid", False),
        row(3, "avoid", True, time=9.0),
        row(3, "avoid", False, "timeout", 30.0),
        row(0, "bounce", True, touches=[(1.2, 1.2)]),
    ]
    assert figures("avoid", rows) == {
        "strategy": "avoid", "runs": 4, "reached": 3, "touched": 3, "touched_moving": 2,
        "fastest_towards_m_s": 0.9, "appeared_too_close": 1, "time_over_no_movers": 5.0 / 4.0,
    }  # fmt: skip
    assert figures("bounce", rows)["time_over_no_movers"] is None


def test_the_command_runs_what_is_missing_and_writes_the_figures(tmp_path, capsys):
    out = tmp_path / "movers.json"
    args = ["--trials", "1", "--seed", "7", "--jobs", "1", "--out", str(out)]
    assert main(args) == 0
    first = out.read_text()
    assert "6 of 6" in capsys.readouterr().err
    assert main(args) == 0
    assert out.read_text() == first
    assert "of" not in capsys.readouterr().err


def test_a_robot_crosses_recorded_walks_to_a_goal_that_stays_free(tmp_path):
    file = tmp_path / "walks.csv"
    places = [(k, 0.4 * i, 0.5 * i, 0.8 * k) for k in range(3) for i in range(8)]
    file.write_text("walker,time_s,x_m,y_m\n" + "\n".join(",".join(map(str, row)) for row in places), encoding="utf-8")
    world = crossing_of(read_walks(file), 0, 5)
    assert 1 <= len(world.movers) <= 3
    for mover in world.movers:
        away = [np.hypot(*(np.array(place_at(mover, time)) - world.goal)) for time in np.arange(3.0, 20.0, 0.2)]
        assert min(away) > 0.69
        assert place_at(mover, 20.0)[0] > 3.5  # who leaves the record walks on


def test_a_file_of_walks_that_holds_none_is_refused_before_a_trial(tmp_path, capsys):
    file = tmp_path / "walks.csv"
    for text, words in (
        ("1,0,0,0\n1,0.4,x,0\n", "walks.csv: line 3: got '1,0.4,x,0', expected walker, time [s], x, y [m]"),
        ("1,0,0\n", "walks.csv: line 2: got '1,0,0', expected walker, time [s], x, y [m]"),
        ("1,0,0,0\n1,0,1,0\n", "walks.csv: got walker 1 twice at 0 s, expected one place at a time"),
        ("", "walks.csv: got no walk, expected two places or more of a walker"),
    ):
        file.write_text("walker,time_s,x_m,y_m\n" + text, encoding="utf-8")
        with pytest.raises(SystemExit, match="2"):
            main(["--walks", str(file), "--out", str(tmp_path / "movers.json")])
        assert words in capsys.readouterr().err
    stands = np.array([[0.0, 1.0, 2.0], [0.4, 1.0, 2.0]])
    with pytest.raises(ValueError, match="walks: got none at"):
        crossing_of([stands], 0, 5)
