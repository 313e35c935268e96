"""Plans of another strategy at each moment of a run, from what was seen until then."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from collplan_core.evaluation.run_end import path_length
from collplan_core.loop.decisions import Cycle, Notice
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.plan import Plan
from collplan_core.replay.comparison import Player
from collplan_core.replay.journal import PLANNER
from collplan_core.replay.reading import Beginning, Call, Event, Gap
from collplan_core.strategies import TIME_TO_GOAL

STRATEGY = "planner.strategy"


@dataclass(frozen=True)
class PlanFigures:
    """A plan in a few figures.

    Attributes:
        duration: time from its stamp to its end [s]; to the goal, if it leads there.
        length: length of its path [m].
        left: distance from its end to the goal, as the crow flies [m].
        first_contact: time from its stamp to the first contact that it foresees [s]; None without one.
    """

    duration: float
    length: float
    left: float
    first_contact: float | None


@dataclass(frozen=True)
class Moment:
    """A moment at which one of two strategies has a plan.

    Attributes:
        stamp: stamp of the newest pose then [s].
        own, other: their plans; None where there is none.
        note: reason why the other one has none.
    """

    stamp: float
    own: PlanFigures | None
    other: PlanFigures | None
    note: str = ""


@dataclass(frozen=True)
class PlansBeside:
    """The plans of two strategies over the same inputs.

    Attributes:
        moments: in order.
        end: reason why they end before the run does; "" where they do not.
    """

    moments: tuple[Moment, ...]
    end: str = ""


def plans_beside(events: Iterable[Event], strategy: str) -> PlansBeside:
    """Plays the journal of the planner twice, once with another strategy, up to the first gap.

    The other strategy keeps its own memory, but for a time-to-goal plan in force, which the robot did not follow. It
    refines as far as the recorded one could, by the same number of looks at the deadline, and to the end where the
    recorded one was a strategy of the paper, which has no deadline.

    Raises:
        JournalError: the journal does not fit the loop.
    """
    found: list[Moment] = []
    players: tuple[Player, Player] | None = None
    for event in events:
        if isinstance(event, Beginning):
            changed = {STRATEGY: strategy}
            players = Player(PLANNER, event), Player(PLANNER, event, changed)
        elif isinstance(event, Gap) or players is None:
            return PlansBeside(tuple(found), str(event))
        else:
            moment = _moment(*players, event, strategy)
            found += [] if moment is None else [moment]
    return PlansBeside(tuple(found))


def _moment(own: Player, other: Player, call: Call, strategy: str) -> Moment | None:
    was = _decided(own, call)
    if strategy in TIME_TO_GOAL and isinstance(other.loop, PlannerLoop):
        other.loop.forget_plan()
    instead = _decided(other, call)
    plans = _plan(own, was), _plan(other, instead)
    if own.stamp is None or plans == (None, None):
        return None
    notes = [each.text for each in instead if isinstance(each, Notice)] if plans[1] is None else []
    return Moment(own.stamp, *plans, "; ".join(notes))


def _decided(player: Player, call: Call) -> list[object]:
    came = player.play(call)
    return came if isinstance(came, list) else []


def _plan(player: Player, decisions: list[object]) -> PlanFigures | None:
    assert isinstance(player.loop, PlannerLoop)
    plan = next((each.plan for each in decisions if isinstance(each, Cycle)), None)
    return None if plan is None else figures_of(plan, player.loop.goal.position)


def figures_of(plan: Plan, goal: np.ndarray) -> PlanFigures:
    """The figures of a plan on the way to a goal (2,) [m]."""
    left = float(np.hypot(*(plan.positions[-1] - goal)))
    contacts = plan.contacts.times
    first = float(contacts[0] - plan.stamp) if len(contacts) else None
    return PlanFigures(float(plan.times[-1] - plan.stamp), path_length(plan.positions), left, first)
