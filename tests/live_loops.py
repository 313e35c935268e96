"""Loops of planner and controller, forked in the middle of a course to set a parameter of one."""

from collections.abc import Callable
from copy import deepcopy
from functools import cache

from live_parameters import others
from recorded_courses import Course, answers, made, recorded

from collplan_core.parameters.spec import ParameterError, Spec

LONGEST = 5.0
"""Longest trial [s]."""
SEEDS = (1, 2, 3)
"""Of the trials; the later ones where the first does not tell."""
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
def mixed(world: str, seed: int = SEEDS[0]) -> Course:
    """A trial in which every cost of the paper's planner has a say."""
    weights = {"weights.position": 100.0, "weights.risk": 30.0, "weights.velocity": 4.0}
    return recorded(world, LONGEST, seed, **{"planner.strategy": "custom", **weights})


def fast(world: str, seed: int = SEEDS[0]) -> Course:
    """Places that the velocity cost alone chooses in."""
    return mixed(world, seed).under(**{"weights.position": 1.0, "weights.risk": 0.1, "weights.velocity": 40.0})


def rebounding(world: str, seed: int = SEEDS[0]) -> Course:
    """Velocities that lead into boundaries, as many as can be, of which the rebound alone says how good they are."""
    weights = {"weights.position": 0.0, "weights.risk": 0.0, "weights.velocity": 40.0}
    kept = {"planner.velocity_pruning": False, "planner.position_pruning": False, "local_map.predicted": "printed"}
    return mixed(world, seed).under(**weights, **kept, **{"planner.collision_factor": False})


def crossing(world: str, seed: int = SEEDS[0]) -> Course:
    """Places of which some are behind a boundary, and the risk of that counts most."""
    weights = {"weights.risk": 1e4, "weights.velocity": 0.0, "planner.gap_weight": 0.0}
    return mixed(world, seed).under(**weights, **{"planner.position_pruning": False, "local_map.half_side": 1.0})


PLANNER_SCENES: dict[str, Scene] = {
    "mixed": lambda: (mixed("corridor"), 1.0, LONGEST),
    "slalom": lambda: (mixed("slalom"), 1.0, 2.0),
    "clutter": lambda: (mixed("random:3"), 1.0, 2.0),
    "fast": lambda: (fast("corridor"), 1.0, 2.0),
    "rebounds": lambda: (rebounding("slalom"), 1.0, LONGEST),
    "crossings": lambda: (crossing("corridor"), 1.0, LONGEST),
    "free speed": lambda: (mixed("corridor").under(**{"weights.risk": 0.1, "weights.velocity": 0.0}), 1.0, 2.0),
    "leap": lambda: (mixed("corridor").with_leap(1.2, 0.06), 1.0, 0.5),
    "poses fail": lambda: (mixed("corridor").without("take_pose", 1.2, 1.3), 1.0, 0.5),
    "scans fail": lambda: (mixed("corridor").without("take_scan", 1.2, 1.4), 1.0, 0.5),
    "stuck": lambda: (mixed("corridor").stuck(1.0), 0.9, LONGEST),
    "time to goal": lambda: (recorded("corridor", 1.2, SEEDS[0], **{"planner.strategy": "bounce"}), 0.9, 0.5),
}
CONTROLLER_SCENES: dict[str, Scene] = {
    "followed": lambda: (mixed("corridor"), 0.8, LONGEST),
    "not told until when": lambda: (mixed("corridor").without("take_valid_until"), 0.8, 1.0),
    "poses fail": lambda: (mixed("corridor").without("take_pose", 1.2, 1.3), 1.0, 0.5),
    "scans fail": lambda: (mixed("corridor").without("take_scan", 1.2, 1.4), 1.0, 0.5),
    "leap": lambda: (mixed("corridor").with_leap(1.2, 0.06), 1.0, 0.5),
    "integral": lambda: (
        mixed("corridor").under(**{"controller.k_i": 2.0, "controller.integral_limit": 0.1}),
        0.8,
        2.0,
    ),
    "through walls": lambda: (mixed("random:3").through_walls(2.5), 0.8, LONGEST),
    "through walls of a slalom": lambda: (mixed("slalom").through_walls(2.5), 0.8, LONGEST),
    "through walls of a corridor": lambda: (mixed("corridor").through_walls(2.5), 0.8, LONGEST),
}
for seed in SEEDS[1:]:
    PLANNER_SCENES |= {
        f"slalom {seed}": lambda seed=seed: (mixed("slalom", seed), 1.0, 2.0),
        f"clutter {seed}": lambda seed=seed: (mixed("random:3", seed), 1.0, 2.0),
        f"fast {seed}": lambda seed=seed: (fast("corridor", seed), 1.0, 2.0),
        f"rebounds {seed}": lambda seed=seed: (rebounding("slalom", seed), 1.0, LONGEST),
    }
    CONTROLLER_SCENES |= {
        f"leap {seed}": lambda seed=seed: (mixed("corridor", seed).with_leap(1.2, 0.06), 1.0, 0.5),
        f"followed {seed}": lambda seed=seed: (mixed("corridor", seed), 0.8, LONGEST),
        f"through walls {seed}": lambda seed=seed: (mixed("random:3", seed).through_walls(2.5), 0.8, LONGEST),
    }
FIRST = {
    "limits.pose_age": ("poses fail",),
    "limits.scan_age": ("scans fail",),
    "limits.plan_age": ("not told until when",),
    "mocap.leap_margin": ("leap",),
    "mocap.velocity_window": ("through walls",),
    "rebound.restitution": ("clutter",),
    "rebound.friction": ("clutter",),
    "planner.recovery_tries": ("stuck",),
    "planner.tie_rule": ("free speed",),
    "planner.n_speeds": ("clutter",),
    "planner.turn_penalty": ("fast",),
    "planner.rebound_horizon": ("fast",),
    "planner.rebound_penalty": ("rebounds",),
    "planner.rebound_reward": ("fast",),
    "planner.goal_vector": ("fast",),
    "planner.approach_risk": ("crossings",),
    "time_to_goal.arrival_share": ("time to goal",),
    "time_to_goal.graze_cost": ("time to goal",),
    "local_map.half_side": ("mixed", "through walls"),
    "local_map.grazing_angle": ("mixed", "through walls"),
    "local_map.surface_tolerance": ("mixed", "leap"),
    "controller.integral_limit": ("integral",),
    "controller.switch_distance": ("leap",),
    "controller.incidence_threshold": ("leap",),
    "controller.maneuver_rule": ("leap",),
}
"""Scenes that are tried before the others, where the first one alone does not tell."""


def changes_loop(kind: type, scenes: dict[str, Scene]) -> Callable[[Spec], bool]:
    """Whether another value of a parameter changes what a loop of this kind puts out in one of these scenes."""

    @cache
    def forked(name: str) -> ForkedLoop:
        return ForkedLoop(kind, *scenes[name]())

    def changes(spec: Spec) -> bool:
        names = sorted(scenes, key=lambda name: name not in FIRST.get(spec.key, ()))
        return any(forked(name).changes({spec.key: value}) for name in names for value in others(spec))

    return changes
