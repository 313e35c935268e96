"""Whole cycles: strategies and their terms, time cut short, what is bad about maps, states and impacts."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.deadline import CountedDeadline, after_looks, never
from collplan_core.movers.record import ALL_STANDS, NEW
from collplan_core.parameters import Settings
from collplan_core.plan import NoPlan
from collplan_core.state import State
from collplan_core.strategies import TIME_TO_GOAL
from collplan_core.time_to_goal_planner import model
from collplan_core.time_to_goal_planner import plan_cycle as plan_cycle_module
from collplan_core.time_to_goal_planner.initial_plans import SWITCH_STEPS, coarse_plans
from collplan_core.time_to_goal_planner.known_map import given_map
from collplan_core.time_to_goal_planner.model import STEP, contact_costs, robot_model
from collplan_core.time_to_goal_planner.plan_cycle import RolloutMemory, plan_cycle
from scenes import box, map_of, unit, world_of
from time_to_goal_scenes import RADIUS, SETTINGS, with_strategy

FEW = settings(derandomize=True, deadline=None, max_examples=6, print_blob=True)
STRATEGIES = sorted(TIME_TO_GOAL)
CHEAP = {
    "remembered__side": 3.0, "time_to_goal__grid_spacing": 0.05, "time_to_goal__proposals": 100
}  # fmt: skip
OPEN = world_of()
TURN = world_of([box(-1.0, 0.2, 0.35, 0.25), box(0.65, -0.5, 0.75, 0.8)])
"""A septum above the robot, and a wall behind its tip."""
AROUND = np.array([-0.2, 0.55])
TRIED = (25, 13, 12)
"""Velocities tried without a plan in force, and by turns with one."""
STEP_CHANGE = SETTINGS.robot.max_acceleration * STEP
"""Change of velocity within a step [m/s]."""
UNREFINED = {"time_to_goal__proposals": 0}


def cheap(strategy: str = "bounce", **values) -> Settings:
    return with_strategy(strategy, **{**CHEAP, **values})


def state_at(position=(0.0, 0.0), velocity=(0.0, 0.0), stamp: float = 0.0) -> State:
    return State(stamp, np.array(position, dtype=float), np.array(velocity, dtype=float), 0.0)


def cycle(memory, world, state: State, goal=AROUND, setting: Settings | None = None, deadline=never):
    local_map = replace(map_of(world, state.position), stamp=state.stamp)
    return plan_cycle(memory, local_map, state, np.array(goal, dtype=float), setting or cheap(), deadline)


def assert_sound(plan, state: State) -> None:
    """Finite, from where the robot is, in order of time, and no faster than it drives."""
    assert plan.stamp == plan.times[0] == state.stamp
    assert (np.diff(plan.times) > 0.0).all()
    for values in (plan.positions, plan.velocities, plan.contacts.times, plan.contacts.points, *plan.terms.values()):
        assert np.isfinite(values).all()
    assert np.isfinite(plan.contacts.velocities_after).all()
    np.testing.assert_array_equal(plan.positions[0], state.position)
    steps = np.hypot(*np.diff(plan.positions, axis=0).T)
    # once out of a wall that the robot is measured in
    assert (steps[1:] <= 1.3 * np.hypot(*plan.velocities.T).max() * np.diff(plan.times)[1:] + 1e-3).all()
    fastest = max(SETTINGS.robot.max_speed, np.hypot(*plan.velocities[0]))
    assert np.hypot(*plan.velocities.T).max() <= fastest + 1e-9
    assert plan.terms["total"] == pytest.approx(plan.terms["arrival_time"] + plan.terms["contact_and_clearance"])


def assert_equal(one, other) -> None:
    for name in ("times", "positions", "velocities", "aim", "aim_velocity"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    for name in ("times", "points", "velocities_after"):
        np.testing.assert_array_equal(getattr(one.contacts, name), getattr(other.contacts, name))
    assert one.terms == other.terms


def driven_on(world, setting: Settings, goal=AROUND, cycles: int = 5, velocity=(0.0, 0.0)):
    memory, state, plans = None, state_at(velocity=velocity), []
    for k in range(cycles):
        plan, memory = cycle(memory, world, state, goal, setting)
        plans.append(plan)
        stamp = 0.05 * (k + 1)
        position = [np.interp(stamp, plan.times, plan.positions[:, a]) for a in range(2)]
        velocity = [np.interp(stamp, plan.times, plan.velocities[:, a]) for a in range(2)]
        state = state_at(position, velocity, stamp)
    return plans, memory


def test_plans_lead_to_the_goal_and_say_what_they_cost():
    for strategy in STRATEGIES:
        plans, memory = driven_on(TURN, cheap(strategy), cycles=3)
        for k, plan in enumerate(plans):
            assert_sound(plan, state_at(plan.positions[0], stamp=0.05 * k))
            assert np.hypot(*(plan.positions[-1] - AROUND)) <= SETTINGS.planner.goal_tolerance, strategy
            assert plan.terms["arrival_time"] <= plan.times[-1] - plan.stamp + 1e-9, strategy
            # first velocity, time of the switch, second velocity
            assert len(plan.candidates.costs) <= plan.n_before_pruning == TRIED[k] * len(SWITCH_STEPS) * TRIED[k], (
                strategy
            )
            assert plan.terms["total"] <= plan.candidates.costs.min(initial=np.inf) + 1.0, strategy
        assert memory.cycle == 3, strategy
        assert len(plans[-1].candidates.paths) >= 2, strategy


def test_refinement_of_a_plan_that_gains_no_more_ends():
    """The deadline is asked once a change: with 20,000 of them it would be more than 500 times."""
    counted = CountedDeadline(never)
    cycle(None, TURN, state_at(), setting=with_strategy("bounce", time_to_goal__proposals=20000), deadline=counted)
    assert 1 < counted.looks < 60


EVEN = {
    "rebound__restitution": 0.0, "time_to_goal__hit_cost": 0.4,
    "time_to_goal__tolerant_distance": 0.02, "time_to_goal__averse_distance": 0.02,
}  # fmt: skip


def test_strategies_differ_in_nothing_but_what_contacts_do_and_cost(monkeypatch):
    monkeypatch.setattr(model, "AVERSE_COSTS", (0.0, 0.4))
    monkeypatch.setattr(model, "INFERRED_COST", 0.4)
    bounce, avoid = cheap("bounce", **EVEN), cheap("avoid", **EVEN)
    assert (robot_model(bounce), contact_costs(bounce)) == (robot_model(avoid), contact_costs(avoid))
    for one, two in zip(*(driven_on(TURN, each, cycles=3)[0] for each in (bounce, avoid)), strict=True):
        assert_equal(one, two)
        np.testing.assert_array_equal(one.candidates.costs, two.candidates.costs)
    unpriced = {**EVEN, "time_to_goal__hit_cost": 0.0}
    assert robot_model(cheap("bounce", **unpriced)) == robot_model(cheap("tolerate", **unpriced))
    avoid, guaranteed = cheap("avoid"), cheap("stop_guarantee")
    assert (robot_model(avoid), contact_costs(avoid)) == (robot_model(guaranteed), contact_costs(guaranteed))


def test_at_full_speed_toward_a_wall_each_strategy_does_its_own():
    """0.2 m before a wall, too late to brake, with the goal behind the robot."""
    world, state = world_of([box(0.2 + RADIUS, -2.0, 0.6, 2.0)]), state_at(velocity=(1.2, 0.0))
    plans = {s: cycle(None, world, state, (-0.6, 0.0), cheap(s, time_to_goal__proposals=1000))[0] for s in STRATEGIES}
    for strategy, plan in plans.items():
        assert_sound(plan, state)
        assert len(plan.contacts.times) >= 1
        back = plan.contacts.velocities_after[0, 0]
        into = plan.velocities[np.searchsorted(plan.times, plan.contacts.times[0]) - 1, 0]
        share = SETTINGS.rebound.restitution if strategy == "bounce" else 0.0
        # driven back for what is left of the step
        assert back == pytest.approx(-share * into, abs=STEP_CHANGE)
    assert plans["bounce"].terms["total"] < min(plans[s].terms["total"] for s in ("avoid", "tolerate")) - 0.2
    # the averse ones brake up to it
    assert np.hypot(*plans["avoid"].velocities[3]) < np.hypot(*plans["bounce"].velocities[3]) - 0.02
    # nothing stops it in time: it brakes with all it has
    after = plans["stop_guarantee"].times[3] - plans["stop_guarantee"].times[0]
    assert plans["stop_guarantee"].velocities[3] == pytest.approx((1.2 - after * 1.5, 0.0), abs=1e-9)


def test_what_was_seen_just_now_is_bounced_off_in_time_but_not_at_once():
    """As if it were solid that is inferred, or the wall that it will be by then."""

    def first(world, state, goal, new: bool, standing_time: float = SETTINGS.movers.standing_time):
        local_map = map_of(world, state.position, half_side=1.2)
        if new:
            local_map = replace(local_map, returns=replace(ALL_STANDS, kinds=np.full(len(local_map.view), NEW)))
        setting = cheap(movers__standing_time=standing_time)
        return plan_cycle(None, local_map, state, np.array(goal), setting)[0]

    wall, fast = world_of([box(0.2 + RADIUS, -2.0, 0.6, 2.0)]), state_at(velocity=(1.2, 0.0))
    soon, stood = (first(wall, fast, (-0.6, 0.0), new) for new in (True, False))
    assert len(soon.contacts.times) == 0 < len(stood.contacts.times)
    assert soon.terms["total"] > stood.terms["total"] + 0.1
    late, never = (first(TURN, state_at(), AROUND, True, standing_time) for standing_time in (0.25, 3.0))
    assert late.contacts.times[0] > 0.6
    assert len(never.contacts.times) == 0
    assert late.terms["total"] < never.terms["total"] - 0.1


def test_no_contact_above_the_limit_is_planned():
    for strategy in STRATEGIES:
        plans, _ = driven_on(TURN, cheap(strategy, limits__impact_speed=0.2), cycles=8, velocity=(0.6, 0.0))
        for plan in plans:
            assert len(plan.contacts.speeds) == len(plan.contacts.times), strategy
            assert plan.contacts.hardest <= 0.2, strategy
    unlimited, _ = driven_on(TURN, with_strategy("bounce"), cycles=4, velocity=(0.6, 0.0))
    assert max(plan.contacts.hardest for plan in unlimited) > 0.2


def test_a_goal_that_closes_off_on_the_way_is_said_to_be_and_opens_again():
    u = [box(0.3, -0.5, 0.4, 0.5), box(-0.5, 0.4, 0.4, 0.5), box(-0.5, -0.5, 0.4, -0.4)]
    lid = box(-0.5, -0.5, -0.4, 0.5)
    plan, memory = cycle(None, world_of(u), state_at(), (1.0, 0.0))
    assert_sound(plan, state_at())
    with pytest.raises(NoPlan, match="closed off"):
        cycle(memory, world_of([*u, lid]), state_at(stamp=0.1), (1.0, 0.0))
    plan, _ = cycle(memory, world_of(u), state_at(stamp=0.2), (1.0, 0.0))
    assert_sound(plan, state_at(stamp=0.2))


def test_the_deadline_is_asked_between_changes_and_the_best_so_far_is_kept():
    endless = cheap(time_to_goal__proposals=5000)

    def cut(looks: int):
        return cycle(None, TURN, state_at(), setting=endless, deadline=after_looks(looks))[0]

    totals = [cut(looks).terms["total"] for looks in (0, 1, 3, 6, 9, 1000)]
    assert totals == sorted(totals, reverse=True)
    assert totals[0] > totals[3] > totals[-1]
    assert_equal(cut(6), cut(6))


jumps = st.tuples(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2))
hostile = st.lists(
    st.tuples(
        st.sampled_from([0.0, 0.0, 0.05, 0.05, -0.05, 0.3, 20.0]),
        st.sampled_from([TURN, OPEN, world_of([box(0.2, -0.6, 0.3, 0.6)]), world_of([], [(0.3, 0.1, 0.1)])]),
        jumps,
        st.floats(0.0, 0.03),
    ),
    min_size=2,
    max_size=5,
)


@FEW
@given(events=hostile, strategy=st.sampled_from(STRATEGIES))
def test_worlds_that_change_impacts_out_of_nothing_and_time_that_stands_or_runs_back(events, strategy):
    memory, state = None, state_at()
    for passed, world, velocity, moved in events:
        state = state_at(state.position + moved * unit(passed), velocity, state.stamp + passed)
        plan, memory = cycle(memory, world, state, setting=cheap(strategy))
        assert_sound(plan, state)


def test_a_flood_of_replans_at_one_stamp_only_gets_better():
    plan, memory = cycle(None, TURN, state_at())
    totals = [plan.terms["total"]]
    for _ in range(6):
        plan, memory = cycle(memory, TURN, state_at())
        assert_sound(plan, state_at())
        totals.append(plan.terms["total"])
    assert max(np.diff(totals)) < 1e-9
    # nothing was learned: neither boundaries nor ways
    _, again = cycle(memory, TURN, state_at())
    assert again.remembered is memory.remembered
    assert again.paths is memory.paths


def test_without_any_plan_that_leads_on_it_begins_with_one_that_brakes(monkeypatch):
    def none_finite(*arguments):
        coarse = coarse_plans(*arguments)
        return coarse._replace(costs=np.full_like(coarse.costs, np.inf))

    monkeypatch.setattr(plan_cycle_module, "coarse_plans", none_finite)
    state = state_at((0.0, 0.0), (0.3, 0.1))
    plan, _ = cycle(
        None, world_of([box(0.9, -2.0, 1.2, 2.0)]), state, (-0.6, 0.0), with_strategy("bounce", **UNREFINED)
    )
    assert_sound(plan, state)
    np.testing.assert_allclose(plan.velocities[-1], 0.0, atol=0.01)
    assert len(plan.candidates.costs) == 0


def test_a_given_map_is_known_from_the_start_and_never_added_to():
    hidden = world_of([box(0.5, -1.2, 0.6, 0.1), box(0.5, 0.9, 0.6, 2.0)], [(2.0, 1.0, 0.2)])
    memory = given_map(hidden, cheap())
    plan, later = cycle(memory, OPEN, state_at(), (1.2, 0.0))
    assert_sound(plan, state_at())
    assert later.remembered is memory.remembered
    assert later.known
    assert plan.positions[np.argmin(np.abs(plan.positions[:, 0] - 0.55)), 1] > 0.1
    assert memory.remembered.field.clearance.min() < 0.0
    assert isinstance(memory, RolloutMemory)
