"""Robots that do not drive as they are believed to, in trials: what is learnt in time, and what must not be learnt."""

import math

import numpy as np

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings
from collplan_core.sensing.pose_filter import FilterResult
from collplan_core.worlds import World, load_world
from faults.bench import Bench
from faults.fault import Fault, Measured
from faults.trials import room, seed_of
from omnipuck_sim.robot.noise import PoseSample
from omnipuck_sim.trial import TrialNodes, run_trial

KNOWN, LEARNT = 0.1, 6.0
"""Share of the true largest acceleration within which it is known, and longest time until then [s]."""
LATE, SEEN = 0.3, 0.01
"""Longest time from the first motion that is seen to zero [s], and the way from which one is seen [m]."""
STRATEGIES = ("bounce", "avoid", "harness")


class Watched:
    """A trial, and what its controller saw and said.

    Attributes:
        result: its result.
        poses: (n, 3) when each was seen [s], and where [m].
        drives: (m, 2) each control period [s], and the largest acceleration in use [m/s^2].
        held: why the robot was held at the end; empty where it was not.
    """

    def __init__(self, world: World, seed: int, **values: float) -> None:
        poses, drives, held = [], [], []

        class Nodes(TrialNodes):
            def filtered(self, sample: PoseSample) -> FilterResult:
                poses.append((self.simulator.time, *sample.position.tolist()))
                return super().filtered(sample)

            def controller(self) -> None:
                super().controller()
                drive = self.loop.controller.drive.in_use
                drives.append((self.simulator.time, drive.max_acceleration if drive else math.nan))
                held.append(self.loop.controller.held)

        named = {key.replace("__", "."): value for key, value in values.items()}
        settings = Settings().with_values({"planner.strategy": STRATEGIES[seed % len(STRATEGIES)], **named})
        self.result = run_trial(world, settings, seed, nodes_class=Nodes)
        self.poses, self.drives, self.held = np.array(poses), np.array(drives), held[-1]


def loaded(bench: Bench, seed: int) -> Measured:
    """It carries half its own mass or all of it, and nobody has told."""
    ratio = 2.0 if seed % 2 else 1.5
    watched = Watched(load_world(f"serpentine:{600 + seed}"), seed, simulator__mass_ratio=ratio)
    true = Settings().robot.max_acceleration / ratio
    known = abs(watched.drives[:, 1] / true - 1.0) < KNOWN
    since = float(watched.drives[np.argmax(known), 0] - watched.result.commands[0, 0]) if known.any() else None
    ended = "" if watched.result.outcome == REACHED else watched.held or watched.result.reason
    return Measured(since, ended)


def late_from_rest(bench: Bench, seed: int) -> Measured:
    """Its poses are late from its start on, which looks as if it were weak."""
    latency = np.random.default_rng([55, seed]).uniform(0.2, 0.5)
    watched = Watched(room({}), seed, simulator__mocap_latency=latency, trial__timeout=3.0)
    way = np.hypot(*(watched.poses[:, 1:] - watched.poses[0, 1:]).T)
    # noise alone takes a single pose of a robot at rest so far
    seen = watched.poses[np.flatnonzero(way <= SEEN)[-1] + 1, 0]
    moving = watched.result.commands[:, 1:3].any(axis=1)
    return Measured(
        max(0.0, float(watched.result.commands[moving, 0].max() - seen)), "" if watched.held else "not held"
    )


FAULTS = [
    Fault(
        "loaded with half its mass or all of it, not told: until a_max is learnt within 10 %",
        "trial",
        LEARNT,
        seed_of,
        loaded,
    ),
    Fault("poses 0.2 to 0.5 s late from rest on: from the first motion seen", "trial", LATE, seed_of, late_from_rest),
]
