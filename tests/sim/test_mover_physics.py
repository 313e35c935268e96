"""Movers in the simulator, with both engines: walls turn them back, they strike the robot, stand before it, are hit."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.parameters import Settings
from collplan_core.worlds import Mover, World, WorldError, load_world
from collplan_core.worlds.route import clearance
from omnipuck_sim.robot.walks import CLEARED, PATIENCE, within_walls
from omnipuck_sim.trial import run_trial
from physics_scenes import RADIUS, RESTITUTION, launched, make_world, quiet

R = 0.12


@pytest.fixture(params=["pymunk", "mujoco"])
def engine(request):
    if request.param == "mujoco":
        pytest.importorskip("mujoco", reason="MuJoCo needs Python 3.11")
    return quiet(engine=request.param)


def scene(*movers: Mover, **world) -> World:
    return replace(make_world(**world), movers=movers)


def coming(speed: float, **keys) -> Mover:
    return Mover(R, np.array([[1.0, 0.0], [-3.0, 0.0]]), speed, **keys)


@given(st.integers(0, 30), st.lists(st.tuples(st.floats(0.0, 2.4), st.floats(0.0, 2.4)), min_size=2, max_size=4))
@settings(max_examples=40, deadline=None)
def test_a_mover_is_never_in_a_wall(seed, way):
    world = load_world(f"random:{seed}")
    try:
        walked = replace(world, movers=(Mover(R, np.array(way), 1.0),))
        mover = within_walls(walked, 0)
    except (ValueError, WorldError):
        return  # a way point in an obstacle, or no room to begin
    line = np.array(
        [shapely.LineString(mover.way).interpolate(s, normalized=True).coords[0] for s in np.linspace(0, 1, 40)]
    )
    # a millionth is left of the roundness of grown corners
    assert min(clearance(world, point, R) for point in (line if len(mover.way) > 1 else mover.way)) > -2e-5


def test_a_wall_is_the_end_of_a_way():
    wall = [[(0.5, -1.0), (0.6, -1.0), (0.6, 1.0), (0.5, 1.0)]]
    way = np.array([[0.0, 0.0], [2.0, 0.0]])
    cut = within_walls(scene(Mover(R, way, 1.0), polygons=wall), 0)
    np.testing.assert_allclose(cut.way, [[0.0, 0.0], [0.5 - R, 0.0]], atol=1e-5)
    with pytest.raises(
        WorldError, match=r"movers\[0\].way\[0\]: \[0.45, 0.0\] is too near an obstacle, expected 0.12 m"
    ):
        within_walls(scene(Mover(R, way + np.array([0.45, 0.0]), 1.0), polygons=wall), 0)


def test_its_velocity_counts_in_the_rebound(engine):
    for robot, speed in ((0.0, 0.8), (0.5, 0.8), (0.5, 0.3), (-0.2, 0.8)):
        sim = launched(scene(coming(speed)), (0.0, 0.0), (robot, 0.0), engine)
        impacts = []
        while not impacts and sim.time < 4.0:
            sim.step()
            impacts += sim.take_impacts()
        assert impacts[0].with_mover
        assert impacts[0].velocity_before[0] == pytest.approx(robot, abs=1e-6)
        expected = -speed - RESTITUTION * (robot + speed)
        assert impacts[0].velocity_after[0] == pytest.approx(expected, abs=0.05 * (robot + speed))
        (touch,) = sim.take_touches()
        assert touch.speed == pytest.approx(robot, abs=1e-6)
        assert touch.time == pytest.approx((1.0 - RADIUS - R) / (robot + speed), abs=0.01)


def test_it_stands_before_a_robot_that_cannot_give_way_and_then_turns_back(engine):
    wall = [[(-1.0, -1.0), (-0.5, -1.0), (-0.5, 1.0), (-1.0, 1.0)]]
    sim = launched(scene(coming(0.6), polygons=wall), (-0.5 + RADIUS + 0.001, 0.0), (0.0, 0.0), engine)
    x = []
    for _ in range(round(4.0 * 800)):
        sim.step()
        x.append(sim.movers[0, 0])
        depth = -clearance(make_world(polygons=wall), sim.state.position, RADIUS)
        assert depth < 0.02  # it is not pushed into the wall
    stood = np.flatnonzero(np.abs(np.diff(x)) < 1e-9)
    assert len(stood) / 800 == pytest.approx(PATIENCE, abs=0.05)
    assert x[-1] > min(x) + 0.5


def test_it_goes_on_when_the_robot_is_out_of_its_way():
    sim = launched(scene(coming(0.6)), (0.0, 0.0), (0.0, 0.0))
    while not sim.take_touches():
        sim.step()
    sim.step(40)
    sim.place(np.array([sim.movers[0, 0], 3.0]))
    sim.step(8)
    assert sim.movers[0, 2] == pytest.approx(-0.6)
    assert CLEARED < 3.0


def test_a_trial_is_hit_and_sees_what_hits_it():
    floor = load_world("floor")
    # comes along the way from start to goal, from behind: the robot is driven into and cannot know
    way = np.array([[0.3, 0.4], [2.1, 1.6]])
    world = replace(floor, movers=(Mover(0.15, way, 1.2, to_and_fro=False),))
    chosen = Settings().with_values({"planner.strategy": "avoid", "lidar.sensor": "low_cost", "robot.max_speed": 0.4})
    result = run_trial(world, chosen, 2)
    assert result.touches
    assert result.movers.shape == (len(result.trajectory), 1, 5)
    first = result.touches[0]
    k = int(np.argmin(np.abs(result.trajectory[:, 0] - first.time)))
    apart = result.trajectory[k, 1:3] - result.movers[k, 0, :2]
    assert np.hypot(*apart) == pytest.approx(RADIUS + 0.15, abs=0.03)
    assert any(abs(impact.velocity_after @ impact.normal) > 0.2 for impact in result.impacts)
