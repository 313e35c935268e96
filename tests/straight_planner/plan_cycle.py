"""A plan straight to the goal at half of the top speed."""

import numpy as np

from collplan_core.deadline import Deadline, never
from collplan_core.local_map import LocalMap
from collplan_core.parameters import Settings
from collplan_core.plan import Candidates, Contacts, Plan
from collplan_core.state import State


def plan_cycle(
    memory: int | None,
    local_map: LocalMap,
    state: State,
    goal: np.ndarray,
    settings: Settings,
    deadline: Deadline = never,
) -> tuple[Plan, int]:
    """The plan, and the number of cycles so far."""
    way = goal - state.position
    duration = max(float(np.hypot(*way)) / (0.5 * settings.robot.max_speed), 0.1)
    share = np.linspace(0.0, 1.0, 50)
    velocities = np.tile(way / duration, (len(share), 1))
    plan = Plan(
        stamp=state.stamp,
        times=state.stamp + duration * share,
        positions=state.position + share[:, None] * way,
        velocities=velocities,
        contacts=Contacts.none(),
        aim=goal,
        aim_velocity=velocities[-1],
        terms={"total": duration},
        candidates=Candidates(goal[None], velocities[:1], np.array([duration])),
        n_before_pruning=1,
    )
    return plan, (memory or 0) + 1
