"""A loop of planner or controller that replays a journal."""

from collections import deque
from collections.abc import Mapping
from typing import Any

from collplan_core.deadline import Deadline, after_looks, never
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.parameters import Settings
from collplan_core.planners import first_memory
from collplan_core.replay.journal import PLANNER
from collplan_core.replay.reading import Beginning, Call
from collplan_core.replay.values import JournalError
from collplan_core.state import State
from collplan_core.worlds.file import parse_text


class Player:
    """A loop, with the external answers recorded in a journal.

    Attributes:
        loop: loop of the planner or the controller.
        stamp: stamp of the newest pose given to it [s]; None before the first.
    """

    def __init__(self, of: str, beginning: Beginning, changed: Mapping[str, object] | None = None) -> None:
        """Makes the loop anew.

        Args:
            of: PLANNER or CONTROLLER.
            beginning: inputs that it is made with.
            changed: parameters that differ from the recorded ones, throughout.
        """
        self.stamp: float | None = None
        self._changed = dict(changed or {})
        self._forbidden: deque[str] = deque()
        self._looks: deque[int | None] = deque()
        settings = beginning.settings.with_values(self._changed)
        self.loop: PlannerLoop | ControllerLoop
        if of == PLANNER:
            text = beginning.known_map
            known_map = first_memory(settings, None if text is None else parse_text(text, "known_map", ""))
            self.loop = PlannerLoop(settings, self._deadline, known_map, self._why_forbidden)
        else:
            self.loop = ControllerLoop(settings, self._why_forbidden)

    def play(self, call: Call) -> Any:
        """Returns the outcome of a call of the loop, or the error that it raises.

        Raises:
            JournalError: the loop has no such input.
        """
        method = None if call.name.startswith("_") else getattr(self.loop, call.name, None)
        if not callable(method):
            raise JournalError(f"call: got {call.name!r}, expected an input of {type(self.loop).__name__}")
        given = [self._given(value) for value in call.args]
        self._forbidden, self._looks = deque(call.forbidden), deque(call.deadline_checks)
        if given and isinstance(given[0], State):
            self.stamp = given[0].stamp
        try:
            return method(*given)
        except Exception as error:  # an outcome as any other: the loop may have done so then
            return error

    def _given(self, value: Any) -> Any:
        return value.with_values(self._changed) if isinstance(value, Settings) else value

    def _why_forbidden(self) -> str:
        return self._forbidden.popleft() if self._forbidden else ""

    def _deadline(self, settings: Settings) -> Deadline:
        looks = self._looks.popleft() if self._looks else None
        return never if looks is None else after_looks(looks)
