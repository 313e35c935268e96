"""What a trial gives to the loops of planner and controller, to be given again to a loop whose parameters change."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest

from collplan_core.command import Command
from collplan_core.deadline import never
from collplan_core.goal import Goal
from collplan_core.loop import closed_loop
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.decisions import Cycle, Notice
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.parameters import Settings
from collplan_core.worlds import load_world
from omnipuck_sim import trial

INPUTS = {
    PlannerLoop: ("take_pose", "take_command", "take_scan", "take_impact", "take_goal", "cycle"),
    ControllerLoop: ("take_pose", "take_scan", "take_goal", "take_plan", "tick"),
}
"""What a trial gives to each loop, and asks of it."""
UNTIMED = ("take_goal",)
"""Inputs of the controller that do not say when they come."""


class Call(NamedTuple):
    """One call of a loop: when [s, local clock], its name and what it is given."""

    time: float
    name: str
    given: tuple[Any, ...]


@dataclass(frozen=True)
class Course:
    """Settings, and the calls of each kind of loop in order."""

    settings: Settings
    calls: dict[type, list[Call]] = field(default_factory=lambda: {kind: [] for kind in INPUTS})

    def under(self, **values: object) -> "Course":
        """The same calls, of loops with other settings."""
        return replace(self, settings=self.settings.with_values(values))

    def changed(self, change: Callable[[Call], Call | None]) -> "Course":
        """Another call, or none, in the place of each."""
        calls = {kind: [other for call in calls if (other := change(call))] for kind, calls in self.calls.items()}
        return replace(self, calls=calls)

    def without(self, name: str, begin: float = -np.inf, end: float = np.inf) -> "Course":
        """The course without these calls in [begin, end) [s]."""
        return self.changed(lambda call: None if call.name == name and begin <= call.time < end else call)

    def with_poses(self, begin: float, change: Callable[[Any], Any]) -> "Course":
        """The course with other poses from `begin` on [s]."""

        def changed(call: Call) -> Call:
            if call.name != "take_pose" or call.time < begin:
                return call
            return call._replace(given=(change(call.given[0]), *call.given[1:]))

        return self.changed(changed)

    def stuck(self, begin: float) -> "Course":
        """The course of a robot that moves no more from `begin` on [s], whatever it is commanded."""
        poses = (call for call in self.calls[PlannerLoop] if call.name == "take_pose")
        place = next(call.given[0].position for call in poses if call.time >= begin)
        return self.with_poses(begin, lambda state: replace(state, position=place, velocity=np.zeros(2)))

    def with_leap(self, begin: float, leap: float) -> "Course":
        """The course with poses that are so far aside from `begin` on [m, s]."""
        aside = np.array([leap, 0.0])
        return self.with_poses(begin, lambda state: replace(state, position=state.position + aside))

    def through_walls(self, factor: float) -> "Course":
        """The course with plans that are longer by a factor, and lead through what is ahead."""

        def changed(call: Call) -> Call:
            if call.name != "take_plan":
                return call
            plan, local = call.given
            start = plan.positions[0]
            return call._replace(given=(replace(plan, positions=start + factor * (plan.positions - start)), local))

        return self.changed(changed)


class _Recorded:
    """A loop, and every call that a trial makes of it."""

    def __init__(self, loop: Any, calls: list[Call], clock: list[float]) -> None:
        self._loop, self._calls, self._clock = loop, calls, clock

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._loop, name)
        if name not in INPUTS[type(self._loop)]:
            return found

        def called(*given: Any) -> Any:
            if isinstance(self._loop, PlannerLoop) or name not in UNTIMED:
                self._clock[0] = given[-1]
            self._calls.append(Call(self._clock[0], name, given))
            return found(*given)

        return called


@cache
def recorded(world: str, longest: float, seed: int, **values: object) -> Course:
    """The course of a trial of at most so long [s], with a heading that is measured with noise."""
    values = {"trial.timeout": longest, "simulator.mocap_yaw_noise": 0.01, **values}
    course, clock = Course(Settings().with_values(values)), [0.0]

    def recording(kind: type) -> Callable[..., _Recorded]:
        return lambda *given, **named: _Recorded(kind(*given, **named), course.calls[kind], clock)

    with pytest.MonkeyPatch.context() as patched:
        for kind in INPUTS:
            patched.setattr(closed_loop, kind.__name__, recording(kind))
        trial.run_trial(load_world(world), course.settings, seed)
    return course


def made(kind: type, settings: Settings) -> Any:
    """A loop of this kind that has all the time it needs for a plan."""
    return PlannerLoop(settings, lambda _: never) if kind is PlannerLoop else ControllerLoop(settings)


def answers(loop: Any, calls: Sequence[Call]) -> Iterator[object]:
    """What a loop puts out at each call, in a form that can be compared."""
    for call in calls:
        answer = getattr(loop, call.name)(*call.given)
        decided = [_put_out(each) for each in answer] if isinstance(answer, list) else _put_out(answer)
        verdict = loop.motion.verdict if isinstance(loop, ControllerLoop) else None
        yield decided, verdict and (verdict.kind, repr(verdict.delay))


def _put_out(answer: Any) -> object:
    """What comes of an answer: its words may hold the parameter itself, and a local map too."""
    if isinstance(answer, Cycle):
        plan = answer.plan
        path = plan.stamp, plan.times, plan.positions, plan.velocities, plan.contacts
        return _comparable((*path, plan.valid_until))
    if isinstance(answer, Notice):
        return answer.level
    if isinstance(answer, Command):
        return _comparable((answer.velocity, answer.yaw_rate, answer.maneuver, bool(answer.reason)))
    if isinstance(answer, Goal):
        return _comparable((answer.stamp, answer.status))
    return bool(answer)


def _comparable(value: Any) -> object:
    """A value that is equal to that of its equal, NaN included."""
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    if is_dataclass(value):
        return tuple(_comparable(getattr(value, each.name)) for each in fields(value))
    return tuple(map(_comparable, value)) if isinstance(value, tuple) else repr(value)
