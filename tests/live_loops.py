"""Loops of planner and controller, forked in the middle of a course to set a parameter of one."""

from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from functools import cache

from live_parameters import others
from recorded_courses import Call, Course, answers, made, recorded

from collplan_core.parameters.spec import ParameterError, Spec
from collplan_core.plan import Plan

LONGEST = 5.0
"""Longest trial [s]."""
SEED = 1
"""Of the trials."""
Scene = Callable[[], tuple[Course, float, float]]
"""The course, when its loops fork [s], and for how long they are compared [s]."""


class ForkedLoop:
    """A loop that was given a course up to a moment, and what it puts out from then on without a change."""

    def __init__(self, kind: type, course: Course, begin: float, lasts: float) -> None:
        """Forks at `begin` and compares for so long [s]."""
        before = [call for call in course.calls[kind] if call.time < begin]
        self._calls = [call for call in course.calls[kind] if begin <= call.time < begin + lasts]
        self._settings, self._loop = course.settings, made(kind, course.settings)
        list(answers(self._loop, before))
        self._unchanged = list(answers(deepcopy(self._loop), self._calls))
        assert not self.changes({}), "equal loops differ"

    def changes(self, values: dict[str, object]) -> bool:
        """Whether the loop puts out something else with these settings."""
        loop = deepcopy(self._loop)
        try:
            loop.change_settings(self._settings.with_values(values))
        except ParameterError:
            return False
        return any(now != then for now, then in zip(answers(loop, self._calls), self._unchanged, strict=True))


@cache
def mixed(world: str) -> Course:
    """A trial in which every cost of the paper's planner has a say."""
    weights = {"weights.position": 100.0, "weights.risk": 30.0, "weights.velocity": 4.0}
    return recorded(world, LONGEST, SEED, **{"planner.strategy": "custom", **weights})


def fast(world: str) -> Course:
    """Places that the velocity cost alone chooses in."""
    return mixed(world).under(**{"weights.position": 1.0, "weights.risk": 0.1, "weights.velocity": 40.0})


def rebounding(world: str) -> Course:
    """Velocities that lead into boundaries, as many as can be, of which the rebound alone says how good they are."""
    weights = {"weights.position": 0.0, "weights.risk": 0.0, "weights.velocity": 40.0}
    kept = {"planner.velocity_pruning": False, "planner.position_pruning": False, "local_map.predicted": "printed"}
    return mixed(world).under(**weights, **kept, **{"planner.collision_factor": False})


def crossing(world: str) -> Course:
    """Places of which some are behind a boundary, and the risk of that counts most."""
    weights = {"weights.risk": 1e4, "weights.velocity": 0.0, "planner.gap_weight": 0.0}
    return mixed(world).under(**weights, **{"planner.position_pruning": False, "local_map.half_side": 1.0})


def not_told(call: Call) -> Call:
    """The call, with a plan that does not say until when it holds."""
    plan = call.given[0]
    return call._replace(given=(replace(plan, valid_until=None), *call.given[1:])) if isinstance(plan, Plan) else call


PLANNER_SCENES: dict[str, Scene] = {
    "clutter": lambda: (mixed("random:3"), 1.0, 2.0),
    "fast": lambda: (fast("corridor"), 1.0, 2.0),
    "rebounds": lambda: (rebounding("slalom"), 1.0, LONGEST),
    "crossings": lambda: (crossing("corridor"), 1.0, LONGEST),
    "leap": lambda: (mixed("corridor").with_leap(1.2, 0.06), 1.0, 0.5),
    "poses fail": lambda: (mixed("corridor").without("take_pose", 1.2, 1.3), 1.0, 0.5),
    "scans fail": lambda: (mixed("corridor").without("take_scan", 1.2, 1.6), 1.0, 0.7),
    "stuck": lambda: (mixed("corridor").stuck(1.0), 0.9, LONGEST),
    "time to goal": lambda: (recorded("corridor", 1.2, SEED, **{"planner.strategy": "bounce"}), 0.9, 0.5),
}
CONTROLLER_SCENES: dict[str, Scene] = {
    "not told until when": lambda: (mixed("corridor").changed(not_told), 0.8, 1.0),
    "poses fail": lambda: (mixed("corridor").without("take_pose", 1.2, 1.3), 1.0, 0.5),
    "leap": lambda: (mixed("corridor").with_leap(1.2, 0.06), 1.0, 0.5),
    "through walls": lambda: (mixed("random:0").through_walls(3.5), 0.8, LONGEST),
    "through a long wall": lambda: (mixed("corridor").through_walls(3.5), 0.8, LONGEST),
}


def changes_loop(kind: type, scenes: dict[str, Scene]) -> Callable[[Spec], bool]:
    """Whether another value of a parameter changes what a loop of this kind puts out in one of these scenes."""

    @cache
    def forked(name: str) -> ForkedLoop:
        return ForkedLoop(kind, *scenes[name]())

    return lambda spec: any(forked(name).changes({spec.key: value}) for name in scenes for value in others(spec))
