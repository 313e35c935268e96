"""How often pruning leaves the choice as it is. Pruning is no dominance, so this is measured, not asserted."""

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
from logged import Logged, cycle, settings_for

from collplan_core.parameters import Settings

TARGET = 0.95


def agreement(states: list[Logged]) -> dict[str, Any]:
    """Share of states in which the pruned plan's aim lies within frontier_spacing of the unpruned one's."""
    chosen = [state for state in states if state.chooses]
    causes = [_cause(state) for state in chosen]
    strategies = sorted({state.strategy for state in chosen})
    by_strategy = {
        name: _tally([cause for state, cause in zip(chosen, causes, strict=True) if state.strategy == name])
        for name in strategies
    }
    # where the goal is in free space it is the aim, and there is nothing to prune
    everywhere = causes + ["agrees"] * (len(states) - len(chosen))
    return {**_tally(causes), "target": TARGET, "by_strategy": by_strategy, "with_goal_in_sight": _tally(everywhere)}


def _tally(causes: list[str]) -> dict[str, Any]:
    counts = Counter(causes)
    agreeing = counts.pop("agrees", 0)
    return {"share": round(agreeing / max(1, len(causes)), 4), "n": len(causes), "disagreements": dict(counts)}


def _cause(state: Logged) -> str:
    """agrees, or which pruning alone already moves the aim, and whether it dropped the aim or reweighed what is left.

    Costs are normalised over the candidates compared, so that fewer candidates can order the same ones differently.
    """
    whole = cycle(state, settings_for(state.strategy, pruned=False)).aim
    if _near(whole, state.plan.aim):
        return "agrees"
    left = np.hypot(*(state.plan.candidates.positions - whole).T).min()
    return f"{_pruning_that_moves(state, whole)}, aim {'still compared' if left < 1e-9 else 'dropped'}"


def _pruning_that_moves(state: Logged, whole: np.ndarray) -> str:
    by_position = not _near(whole, cycle(state, _only(state.strategy, position_pruning=True)).aim)
    by_velocity = not _near(whole, cycle(state, _only(state.strategy, velocity_pruning=True)).aim)
    if by_position and by_velocity:
        return "either pruning"
    return "position pruning" if by_position else "velocity pruning" if by_velocity else "both together"


def _only(strategy: str, **pruning: bool) -> Settings:
    settings = settings_for(strategy, pruned=False)
    return replace(settings, planner=replace(settings.planner, **pruning))


def _near(a: np.ndarray, b: np.ndarray) -> bool:
    return float(np.hypot(*(a - b))) <= Settings().planner.frontier_spacing
