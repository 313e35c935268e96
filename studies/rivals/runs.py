"""The runs that are compared: which they are, and a row of figures for each."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from time import thread_time
from typing import Any, NamedTuple

from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.planners import PLANNERS, Planner, register
from collplan_core.worlds import World, load_world
from collplan_study.question.bounces import SPREADS
from collplan_study.question.question import parse_axes
from omnipuck_sim.trial import run_trial
from optimum.disc import disc_of
from optimum.world_optimum import world_optimum
from rivals.sst import followed, search

WORLDS = {"serpentine": 8, "u": 8, "baffles": 4}
"""Families, and how many worlds of each."""
FIRST_WORLD = 8200
"""Seed of the first world of each family; nothing was tuned on these."""
OPTIMUM = "optimum"
OURS = {name: PLANNERS[name] for name in ("bounce", "avoid")}
SST = {"SST, 1 s": 1.0, "SST, 10 s": 10.0}
"""Duration of each search [s]."""
MPPI, MPPI_WORLDS = {"MPPI": "avoid", "MPPI, bounce's costs": "bounce"}, 4
"""The strategy whose contacts and costs each has, and in how many worlds of a family they run."""
RIVALS = (*OURS, *SST, *MPPI)
VALUES = {key: value for key, (value,) in parse_axes(SPREADS).items()}
"""Parameters that are not as shipped, the strategy aside."""


class Case(NamedTuple):
    """A world, and who runs in it: a rival, or OPTIMUM for the best without contact."""

    world: str
    who: str


def cases(most: int) -> Iterator[Case]:
    """All runs in at most so many worlds of each family."""
    for k, (family, count), who in product(range(most), WORLDS.items(), (OPTIMUM, *RIVALS)):
        if k < (min(count, MPPI_WORLDS) if who in MPPI else count):
            yield Case(f"{family}:{FIRST_WORLD + k}", who)


def figures(case: Case) -> dict[str, Any]:
    """Returns outcome, time [s], contacts and processor time of each plan [ms] of a run; for the optimum the time."""
    world, settings = load_world(case.world), Settings().with_values(VALUES)
    if case.who == OPTIMUM:
        return {"time": world_optimum(world, disc_of(settings)).time}
    if case.who in OURS:
        return _run(world, settings.with_values({"trial.known_map": True}), case.who, OURS[case.who])
    if case.who in SST:
        plan, took, motions = search(world, settings.with_values({"planner.strategy": "avoid"}), SST[case.who])
        planning = {"planning_ms": [1e3 * took], "motions": motions}
        if plan is None:
            return {"outcome": "no plan", "time": None, "contacts": 0, **planning}
        return {**_run(world, settings, "rival", followed(plan)), **planning, "planned": float(plan.times[-1])}
    from rivals.mppi import mppi_planner

    costs = settings.with_values({"planner.strategy": MPPI[case.who]})
    return _run(world, settings, "rival", mppi_planner(world, costs))


def _run(world: World, settings: Settings, strategy: str, planner: Planner) -> dict[str, Any]:
    taken = list[float]()

    def timed(*given: Any, **named: Any) -> tuple[Plan, Any]:
        begun = thread_time()
        found = planner.plan(*given, **named)
        taken.append(round(1e3 * (thread_time() - begun), 2))
        return found

    register(strategy, replace(planner, plan=timed))
    result = run_trial(world, settings.with_values({"planner.strategy": strategy}), seed=0)
    figures = {"outcome": result.outcome, "time": result.arrival_time, "contacts": len(result.impacts)}
    return {**figures, "planning_ms": taken}
