"""The whole cycle from a scan to a plan: symmetries, special cases, memory, and every choice by name."""

from dataclasses import replace
from functools import partial
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from collplan_core.local_map import build_local_map, seen
from collplan_core.movers.record import ALL_STANDS, NO_MOVERS
from collplan_core.paper_planner.costs.model import weights_of
from collplan_core.paper_planner.plan_cycle import meets_a_mover, plan_cycle
from collplan_core.paper_planner.trajectory import PEAK
from collplan_core.parameters import Settings, Weights
from collplan_core.plan import NoPlan
from collplan_core.strategies import PAPER_WEIGHTS
from collplan_core.worlds import World
from scenes import (
    ROBOT,
    SETTINGS,
    at_rest,
    box,
    cluttered_worlds,
    map_of,
    mover_at,
    rotation,
    scan_of,
    uneven_world,
    world_of,
)

GOALS = st.tuples(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0)).map(np.array)
VELOCITIES = st.tuples(st.floats(-0.8, 0.8), st.floats(-0.8, 0.8)).map(np.array)


def cycle(world, state, goal, settings=SETTINGS, memory=None):
    local_map = build_local_map(scan_of(world, state), state, ROBOT, settings.local_map)
    return plan_cycle(memory, local_map, state, goal, settings)


def moved(world: World, turn: np.ndarray, shift: np.ndarray) -> World:
    corners = np.array(world.bounds).reshape(2, 2) @ turn.T + shift
    circles = np.array([(*(turn @ c[:2] + shift), c[2]) for c in world.circles])
    return World(
        "moved", tuple(p @ turn.T + shift for p in world.polygons), circles,
        (*corners.min(axis=0), *corners.max(axis=0)), world.walled,
    )  # fmt: skip


def is_close_call(plan) -> bool:
    """Whether rounding may decide: between two candidates, or on which side of a corner of the map one lies."""
    costs, positions = plan.candidates.costs, np.abs(plan.candidates.positions)
    at_corner = np.isclose(positions, SETTINGS.local_map.half_side, atol=1e-6).all(axis=1)
    return (len(costs) > 1 and np.diff(np.sort(costs)[:2])[0] < 1e-5) or at_corner.any()


@given(
    seed=st.integers(0, 2**32 - 1),
    strategy=st.sampled_from(sorted(PAPER_WEIGHTS)),
    quarter=st.integers(0, 3),
    mirror=st.booleans(),
)
@patch.object(seen, "SURFACE_TOLERANCE", 1e-6)
def test_the_cycle_moves_with_the_world(seed, strategy, quarter, mirror):
    # which hit beside a corner ends a wall's piece is a matter of order, and so of the mirror, within the tolerance
    rng = np.random.default_rng(seed)
    world, goal, velocity, shift = uneven_world(rng), *rng.uniform(-1.0, 1.0, (3, 2)) * [[4.0], [0.8], [4.0]]
    chosen = SETTINGS.with_values({"planner.strategy": strategy})
    turn = rotation(quarter * np.pi / 2).round() @ np.diag([1.0, -1.0 if mirror else 1.0])
    try:
        plan, _ = cycle(world, at_rest(velocity=velocity), goal, chosen)
    except NoPlan:
        with pytest.raises(NoPlan):
            cycle(moved(world, turn, shift), at_rest(shift, velocity=turn @ velocity), turn @ goal + shift, chosen)
        return
    assume(not is_close_call(plan))
    other, _ = cycle(moved(world, turn, shift), at_rest(shift, velocity=turn @ velocity), turn @ goal + shift, chosen)
    np.testing.assert_allclose(np.sort(other.candidates.costs), np.sort(plan.candidates.costs), atol=1e-5)
    np.testing.assert_allclose(other.positions, plan.positions @ turn.T + shift, atol=1e-6)
    np.testing.assert_allclose(other.velocities, plan.velocities @ turn.T, atol=1e-6)
    np.testing.assert_allclose(other.times, plan.times, atol=1e-6)
    np.testing.assert_allclose(other.aim, turn @ plan.aim + shift, atol=1e-6)
    np.testing.assert_allclose(other.contacts.times, plan.contacts.times, atol=1e-4)
    # in the notch between two obstacles either normal is as good
    np.testing.assert_allclose(other.contacts.points, plan.contacts.points @ turn.T + shift, atol=0.05)
    for name, value in plan.terms.items():
        assert other.terms[name] == pytest.approx(value, abs=1e-6)


@given(world=cluttered_worlds(), goal=GOALS, velocity=VELOCITIES, strategy=st.sampled_from(sorted(PAPER_WEIGHTS)))
def test_a_plan_is_a_sound_reference(world, goal, velocity, strategy):
    chosen = SETTINGS.with_values({"planner.strategy": strategy})
    try:
        plan, _ = cycle(world, at_rest(velocity=velocity), goal, chosen)
    except NoPlan:
        return
    assert (np.diff(plan.times) > 0).all()
    assert plan.times[0] == plan.stamp
    assert plan.times[-1] - plan.times[0] >= chosen.planner.map_period - 1e-12
    np.testing.assert_allclose(plan.positions[[0, -1]], [[0.0, 0.0], plan.aim], atol=1e-12)
    assert np.hypot(*plan.velocities.T).max() <= ROBOT.max_speed * (1 + 1e-3)
    steps = np.diff(plan.positions, axis=0) / np.diff(plan.times)[:, None]
    assert np.hypot(*steps.T).max() <= ROBOT.max_speed * (1 + 1e-3)
    changes = np.diff(plan.velocities, axis=0) / np.diff(plan.times)[:, None]
    most = PEAK * ROBOT.max_acceleration
    assert np.hypot(*changes.T).max() <= most * (1 + 1e-3)
    assert 1 <= len(plan.candidates.costs) <= plan.n_before_pruning
    assert plan.terms["total"] <= plan.candidates.costs.min() + 1e-2


def test_a_goal_in_free_space_is_the_aim_and_the_end():
    plan, memory = cycle(world_of(), at_rest(velocity=(0.5, 0.0)), np.array([0.3, 0.2]))
    np.testing.assert_array_equal(plan.aim, [0.3, 0.2])
    assert not plan.aim_velocity.any()
    np.testing.assert_allclose(plan.positions[-1], [0.3, 0.2])
    np.testing.assert_allclose(plan.velocities[-1], 0.0, atol=1e-12)
    # and what comes next is not held against it
    assert np.isnan(memory.aim).all()


def test_the_strategies_of_the_paper_have_its_weights():
    weights = {name: Weights(**PAPER_WEIGHTS[name]) for name in ("harness", "high_risk", "low_risk")}
    assert {name: (w.risk, w.velocity) for name, w in weights.items()} == {
        "harness": (0.1, 4.0),
        "high_risk": (0.1, 0.0),
        "low_risk": (100.0, 0.0),
    }
    assert len({w.position for w in weights.values()}) == 1
    own = Settings(weights=Weights(1.0, 2.0, 3.0))
    assert weights_of(own) == Weights(**PAPER_WEIGHTS["harness"])
    assert weights_of(own.with_values({"planner.strategy": "custom"})) == Weights(1.0, 2.0, 3.0)


SCENE = world_of([box(0.2, -0.05, 0.3, 0.25), box(0.5, -3.0, 0.6, 0.1), box(-0.3, 0.4, 0.1, 0.5)])
MEMORY = plan_cycle(None, map_of(SCENE, (-0.1, 0.0)), at_rest((-0.1, 0.0)), np.array([-1.0, -1.0]), SETTINGS)[1]


def fingerprint(values: dict, strategy: str) -> tuple:
    chosen = SETTINGS.with_values({"planner.strategy": strategy, **values})
    state = at_rest(velocity=(0.6, 0.5))
    plan, _ = plan_cycle(MEMORY, map_of(SCENE), state, np.array([2.0, 1.0]), chosen)
    parts = (plan.candidates.costs, plan.candidates.velocities.ravel(), plan.aim_velocity, plan.positions.ravel())
    return (*(tuple(part.round(9)) for part in parts), round(plan.times[-1], 9), plan.n_before_pruning)


def test_every_choice_by_name_has_its_effect():
    for key, value in [
        ("position_cost", "printed"),
        ("turn_angle", "printed"),
        ("gap_risk", "printed"),
        ("approach_risk", "printed"),
        ("goal_vector", "unit"),
        ("rebound_reward", False),
        ("collision_factor", False),
        ("speeds", "printed"),
        ("frontiers", "printed"),
        ("waypoints", "chord"),
        ("time_law", "printed"),
        ("position_pruning", False),
        ("velocity_pruning", False),
    ]:
        assert fingerprint({f"planner.{key}": value}, "harness") != fingerprint({}, "harness"), (key, value)


a_mover = partial(mover_at, radius=0.1, growth=0.1)


def test_a_way_that_a_mover_is_in_is_told_from_one_beside_it_behind_it_or_away_from_it():
    ahead, behind, aside = np.array([0.6, 0.0]), np.array([-0.6, 0.0]), np.array([0.0, 0.6])
    points = np.array([ahead, behind, aside])
    for mover, blocked in (
        (a_mover(0.45, 0.0), [True, False, False]),
        (a_mover(0.1, 0.0), [True, False, False]),  # it touches the robot, which may leave it
        (a_mover(0.6, 0.0, (-1.2, 0.0)), [True, True, False]),  # faster than the robot flees, but it can dodge
        (a_mover(0.45, 0.0, (0.0, 1.2)), [False, False, False]),  # gone when the robot is there
        (a_mover(0.4, 0.5, (0.0, -0.5)), [True, False, False]),
    ):
        np.testing.assert_array_equal(meets_a_mover(points, mover, at_rest((0.0, 0.0)), SETTINGS), blocked)
    assert not meets_a_mover(points, NO_MOVERS, at_rest((0.0, 0.0)), SETTINGS).any()


@pytest.mark.parametrize("strategy", sorted(PAPER_WEIGHTS))
@pytest.mark.parametrize("goal", [(0.5, 0.0), (3.0, 0.0)])
def test_it_drives_round_a_mover_that_stands_in_its_way(strategy, goal):
    settings, state, goal = SETTINGS.with_values({"planner.strategy": strategy}), at_rest((0.0, 0.0)), np.array(goal)
    local_map = build_local_map(scan_of(world_of(), state), state, ROBOT, settings.local_map)
    free, _ = plan_cycle(None, local_map, state, goal, settings)
    assert np.abs(free.positions[:, 1]).max() < 0.05
    there = replace(ALL_STANDS, movers=a_mover(0.3, 0.0))
    plan, _ = plan_cycle(None, replace(local_map, returns=there), state, goal, settings)
    assert not meets_a_mover(plan.aim[None], there.movers, state, settings)[0]
