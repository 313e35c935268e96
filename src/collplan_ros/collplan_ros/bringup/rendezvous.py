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
        places: the place of each robot, in order.
        turn: held by the thread whose nodes run: one at a time.
        stop_signal: signals that end all of them.
        refused: why one of them could not be started; empty where none was refused.
    """

    def __init__(self, starts: Sequence[np.ndarray]) -> None:
        """Takes the start (2,) [m] of each robot."""
        self.places = [Place(self, start) for start in starts]
        self.turn = threading.Condition()
        self.stop_signal = StopSignal()
        self.refused = ""
        self._company: Any = None

    def run(self, drives: Sequence[Callable[[], T]]) -> list[T]:
        """Runs a function for each robot until all have ended, the first in this thread; returns what they return.

        Raises:
            StartError: one of them did, once all have ended.
        """

        def run_one(place: Place, drive: Callable[[], T]) -> T:
            try:
                return drive()
            except StartError as error:
                self.refused = str(error)
                raise
            finally:
                place.leave()

        first, *others = zip(self.places, drives, strict=True)
        with self.stop_signal.listening(), ThreadPoolExecutor(len(others)) as pool:
            running = [pool.submit(run_one, *other) for other in others]
            return [run_one(*first), *(each.result() for each in running)]

    def gather(self) -> None:
        """Puts the simulators into one world, once all are there."""
        simulators = [place.simulator for place in self.places]
        if None not in simulators:
            self._company = resolve_name(COMPANY)(simulators)

    def step_if_due(self) -> None:
        """Advances the physics by a step, where every robot that is here waits for that."""
        here = [place for place in self.places if place.is_here]
        if here and all(place.waits for place in here):
            self._company.step()
            for place in here:
                place.waits = False
            self.turn.notify_all()


class Place:
    """The place of one robot among others in a world.

    Attributes:
        start: (2,) where it begins [m].
        rendezvous: where it meets the others.
        simulator: the robot; None before it has come.
        is_here, is_ready, waits: whether its graph has not ended, was ready, and waits for a step of the physics.
    """

    def __init__(self, rendezvous: Rendezvous, start: np.ndarray) -> None:
        self.rendezvous, self.start = rendezvous, start
        self.simulator: Any = None
        self.is_here, self.is_ready, self.waits = True, False, False

    def all_ready(self) -> bool:
        """Notes that this robot is ready; returns whether all are.

        Raises:
            StartError: one of them could not be started.
        """
        self.is_ready = True
        if self.rendezvous.refused:
            raise StartError(self.rendezvous.refused)
        return all(place.is_ready for place in self.rendezvous.places if place.is_here)

    def leave(self) -> None:
        """Waits for this robot no longer, as its graph ends; its body stays."""
        with self.rendezvous.turn:
            self.is_here = False
            self.rendezvous.step_if_due()

    def share(self, simulator: Any) -> Callable[[], None]:
        """Puts a simulator among the others; returns what advances all of them by a step, once all ask for it."""
        self.simulator = simulator
        self.rendezvous.gather()

        def pass_step() -> None:
            with self.rendezvous.turn:
                self.waits = True
                self.rendezvous.step_if_due()
                self.rendezvous.turn.wait_for(lambda: not self.waits)

        return pass_step
