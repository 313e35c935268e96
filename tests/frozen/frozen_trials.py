"""48 short trials: each family of worlds with six strategies."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from collplan_core import Settings
from collplan_core.worlds.families import FAMILIES
from fingerprint import fingerprint
from omnipuck_sim import run_trial
from omnipuck_sim.trial_record import TrialResult

STRATEGIES = ("harness", "low_risk", "bounce", "tolerate", "avoid", "stop_guarantee")
SECONDS = 3.0
"""Length of a trial [s]: past its first contacts, most not yet at the goal."""
SEEDS = {family: 31 + k for k, family in enumerate(sorted(FAMILIES))} | {"serpentine": 56}
"""Seed of each family's world; in serpentine:36 `tolerate` went another way with the last bits of an old processor."""


def names() -> list[tuple[str, str]]:
    """World and strategy of each trial."""
    return [(f"{family}:{seed}", strategy) for family, seed in SEEDS.items() for strategy in STRATEGIES]


def frozen_trial(world: str, strategy: str) -> dict[str, Any]:
    """Result of a trial: for people, and as the fingerprints of its commands, plans and impacts."""
    result = run_trial(world, Settings().with_values({"planner.strategy": strategy, "trial.timeout": SECONDS}), seed=5)
    said = {"outcome": result.outcome, "path_length": result.path_length, "plans": len(result.plans)}
    return said | {"impacts": len(result.impacts)} | {name: fingerprint(part) for name, part in _parts(result)}


def _parts(result: TrialResult) -> Iterator[tuple[str, Any]]:
    yield "commands", result.commands
    yield "motion", result.trajectory
    yield "plan", [np.array(plan) for plan in result.plans]
    yield "impact", [[h.time, *h.point, *h.normal, *h.velocity_before, *h.velocity_after] for h in result.impacts]
