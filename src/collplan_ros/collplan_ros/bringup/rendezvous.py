"""Robots of one simulated world, each run by bringup in a thread of its own, that pass simulated time together."""

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pkgutil import resolve_name
from typing import Any, TypeVar

import numpy as np

from collplan_ros.bringup.failures import StartError
from collplan_ros.node_kit.stop_signal import StopSignal

COMPANY = "omnipuck_sim.robot.company:Company"
"""The class of the shared physics: a name, so that this package does not depend on the simulator's."""
T = TypeVar("T")


class Rendezvous:
    """Where the robots wait for each other before each step of the physics.

    Attributes:
        turn: held by the thread whose nodes run: one at a time.
        stop_signal: signals that end all of them.
    """

    def __init__(self, starts: Sequence[np.ndarray]) -> None:
        """Takes the start (2,) [m] of each robot."""
        self.turn = threading.Condition()
        self.stop_signal = StopSignal()
        self._starts = starts
        self._simulators: dict[int, Any] = {}
        self._company: Any = None
        self._here = set(range(len(starts)))
        self._ready: set[int] = set()
        self._waiting: set[int] = set()
        self._steps = 0
        self._refused = ""

    def places(self) -> list["Place"]:
        """The place of each robot, in order."""
        return [Place(self, number, start) for number, start in enumerate(self._starts)]

    def run(self, drives: Sequence[Callable[[], T]]) -> list[T]:
        """Runs a function for each robot until all have ended, the first in this thread; returns what they return.

        Raises:
            StartError: one of them did, once all have ended.
        """

        def run_one(number: int) -> T:
            try:
                return drives[number]()
            except StartError as error:
                self._refused = str(error)
                raise
            finally:
                self.leave(number)

        with self.stop_signal.listening(), ThreadPoolExecutor(len(drives)) as pool:
            others = [pool.submit(run_one, number) for number in range(1, len(drives))]
            return [run_one(0), *(other.result() for other in others)]

    def join(self, number: int, simulator: Any) -> None:
        """Takes the simulator of a robot."""
        self._simulators[number] = simulator
        if len(self._simulators) == len(self._starts):
            self._company = resolve_name(COMPANY)([self._simulators[k] for k in range(len(self._starts))])

    def all_ready(self, number: int) -> bool:
        """Notes that a robot is ready; returns whether all are.

        Raises:
            StartError: one of them could not be started.
        """
        self._ready.add(number)
        if self._refused:
            raise StartError(self._refused)
        return self._here <= self._ready

    def pass_step(self, number: int) -> None:
        """Advances the physics by a step, once every robot whose graph runs asks for it."""
        with self.turn:
            self._waiting.add(number)
            if not self._step_if_due():
                steps = self._steps
                self.turn.wait_for(lambda: self._steps > steps)

    def leave(self, number: int) -> None:
        """Waits for a robot no longer, as its graph ends; its body stays."""
        with self.turn:
            self._here.discard(number)
            self._step_if_due()

    def _step_if_due(self) -> bool:
        if not self._waiting or not self._here <= self._waiting:
            return False
        self._company.step()
        self._waiting.clear()
        self._steps += 1
        self.turn.notify_all()
        return True


class Place:
    """The place of one robot among others in a world.

    Attributes:
        start: (2,) where it begins [m].
        turn: held while its nodes run.
        stop_signal: signals that end it.
    """

    def __init__(self, rendezvous: Rendezvous, number: int, start: np.ndarray) -> None:
        self.start, self.turn, self.stop_signal = start, rendezvous.turn, rendezvous.stop_signal
        self._rendezvous, self._number = rendezvous, number

    def all_ready(self) -> bool:
        """Notes that this robot is ready; returns whether all are. Raises StartError as `Rendezvous`."""
        return self._rendezvous.all_ready(self._number)

    def leave(self) -> None:
        """Waits for this robot no longer."""
        self._rendezvous.leave(self._number)

    def share(self, simulator: Any) -> Callable[[], None]:
        """Puts a simulator among the others; returns what advances all of them by a step, once all ask for it."""
        self._rendezvous.join(self._number, simulator)
        return lambda: self._rendezvous.pass_step(self._number)
