"""Several robots in one simulated world: they hit each other as bodies of equal mass do, and pass time together."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.parameters import ParameterError
from collplan_core.worlds import Mover, WorldError
from omnipuck_sim.robot.company import Company
from physics_scenes import MASS, MOMENT, QUIET, RADIUS, RESTITUTION, launched, make_world, quiet

ROOM = make_world()


def meeting(first, second, aside=0.0, world=ROOM):
    """Two robots that fly at each other, and their company, stepped until they are apart again."""
    robots = [launched(world, (-0.4, 0.0), first), launched(world, (0.4, aside), second)]
    company = Company(robots)
    for _ in range(1600):
        company.step()
    return robots


@given(
    st.tuples(st.floats(0.3, 1.2), st.floats(-0.2, 0.2)),
    st.tuples(st.floats(-1.2, -0.3), st.floats(-0.2, 0.2)),
    st.floats(-0.1, 0.1),
)
@settings(max_examples=30, deadline=None, derandomize=True)
def test_a_hit_keeps_momentum_and_both_turn_alike_and_energy_does_not_grow(first, second, aside):
    robots = meeting(first, second, aside)
    before, after = np.array([first, second]), np.array([robot.state.velocity for robot in robots])
    np.testing.assert_allclose(after.sum(axis=0), before.sum(axis=0), atol=1e-9)
    # a contact between equal discs turns both the same way
    assert robots[0].spin == pytest.approx(robots[1].spin, abs=1e-9)
    energy = [MASS * (v**2).sum() for v in (before, after)]
    assert energy[1] + MOMENT * sum(robot.spin**2 for robot in robots) <= energy[0] * (1.0 + 1e-9)
    if np.abs(after - before).max() > 1e-6:
        impacts = [robot.take_impacts() for robot in robots]
        assert len(impacts[0]) == len(impacts[1])
        for one, other in zip(*impacts, strict=True):
            assert one.time == other.time
            np.testing.assert_allclose(one.normal, -other.normal, atol=1e-9)
            np.testing.assert_allclose(one.point, other.point, atol=4e-3)


def test_head_on_they_exchange_what_restitution_leaves():
    robots = meeting((0.8, 0.0), (-0.4, 0.0))
    middle = 0.2
    velocities = [robot.state.velocity[0] for robot in robots]
    assert velocities == pytest.approx([middle - RESTITUTION * 0.6, middle + RESTITUTION * 0.6], abs=1e-6)
    (impact,) = robots[0].take_impacts()
    assert impact.velocity_before == pytest.approx([0.8, 0.0])
    assert impact.normal == pytest.approx([-1.0, 0.0])
    assert impact.with_mover


def test_one_that_stands_is_pushed_off_and_one_that_is_missed_is_not():
    robots = meeting((0.9, 0.0), (0.0, 0.0))
    assert robots[1].state.velocity[0] == pytest.approx(0.9 * (1.0 + RESTITUTION) / 2.0, abs=1e-6)
    robots = meeting((0.9, 0.0), (0.0, 0.0), aside=2.1 * RADIUS)
    assert robots[0].state.velocity.tolist() == [0.9, 0.0]
    assert robots[1].state.velocity.tolist() == [0.0, 0.0]


def test_both_driven_at_each_other_stay_apart_and_so_between_a_wall_and_another():
    wall = make_world([[(0.4 + RADIUS, -1.0), (1.0, -1.0), (1.0, 1.0), (0.4 + RADIUS, 1.0)]])
    for world, ways in ((ROOM, (0.5, -0.5)), (wall, (0.5, 0.5))):
        robots = [launched(world, (-0.4, 0.0), (0.0, 0.0)), launched(world, (0.4, 0.0), (0.0, 0.0))]
        company = Company(robots)
        gaps = []
        for _ in range(4 * 800):
            for robot, way in zip(robots, ways, strict=True):
                robot.drive = True
                robot.command(np.array([way, 0.0]), 0.0)
            company.step()
            gaps.append(robots[1].state.position[0] - robots[0].state.position[0] - 2.0 * RADIUS)
        assert all(robot.take_impacts() for robot in robots)
        assert min(gaps) > -0.005
        assert gaps[-1] == pytest.approx(0.0, abs=0.003)
        assert robots[1].state.position[0] < 0.4 + 0.003


def test_each_is_among_what_moves_for_the_other_and_alone_nothing_changes():
    robots = [launched(ROOM, (-0.4, 0.0), (0.3, 0.1)), launched(ROOM, (1.4, 0.5), (0.0, 0.0))]
    company = Company(robots)
    alone = launched(ROOM, (-0.4, 0.0), (0.3, 0.1))
    for _ in range(400):
        company.step()
        alone.step()
    assert robots[0].state.position.tolist() == alone.state.position.tolist()
    np.testing.assert_array_equal(robots[1].movers, [[*alone.state.position, 0.3, 0.1, RADIUS]])
    np.testing.assert_array_equal(robots[0].movers, [[1.4, 0.5, 0.0, 0.0, RADIUS]])
    assert alone.movers.shape == (0, 5)


def test_what_it_cannot_do_is_an_error():
    def pair(world=ROOM, chosen=QUIET, second=(0.4, 0.0)):
        return [launched(world, place, (0.0, 0.0), chosen) for place in ((-0.4, 0.0), second)]

    with pytest.raises(WorldError, match=r"start: robot 1 stands 0\.0.* m inside another, expected apart"):
        Company(pair(second=(-0.4 + RADIUS, 0.0)))
    walked = replace(ROOM, movers=(Mover(0.1, np.array([[3.0, 3.0]]), 1.0),))
    with pytest.raises(WorldError, match="world scene: movers: got 1, expected none"):
        Company(pair(walked))
    pytest.importorskip("mujoco", reason="MuJoCo needs Python 3.11")
    with pytest.raises(ParameterError, match=r"simulator\.engine: got mujoco, expected pymunk for several robots"):
        Company(pair(chosen=quiet(engine="mujoco")))
