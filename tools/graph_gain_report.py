"""The tables of graph_gain: gains in trials and through the graph, what did not arrive, and where the time went."""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from collplan_core.evaluation.run_end import REACHED
from collplan_study.analysis.bounce_results import AGAINST, OURS
from collplan_study.analysis.statistics import MEAN, Estimate, level_of, share_of
from collplan_study.report.content import number, with_interval
from omnipuck_sim.trial import CONTROLLER_PHASE, PLANNER_PHASE
from plan_delays import LATE, STAGES, delay_table

FAMILIES = ("serpentine", "u")
STRATEGIES = (OURS, AGAINST)
TRIAL, GRAPH = "trial", "graph"
KINDS = tuple(product((TRIAL, GRAPH), STRATEGIES))
"""The four runs of a world and a seed, which are compared with one another."""


class Case(NamedTuple):
    """A run: where, with which seed of the noise, how, and whether it is a TRIAL or goes through the GRAPH."""

    world: str
    seed: int
    strategy: str
    kind: str

    def __str__(self) -> str:
        return f"{self.world} {self.strategy} seed {self.seed}, {self.kind}"


def case_of(row: dict) -> Case:
    """Which run a row is of."""
    return Case(*(row[key] for key in Case._fields))


def report(rows: Sequence[dict]) -> str:
    """Both tables, and what must be known to read them."""
    through_graph = [row for row in rows if row["kind"] == GRAPH]
    parts = [
        gain_table(rows),
        f"A gain is 100 (1 - {OURS} / {AGAINST}) of two arrival times, in the mean over the worlds; left is the gain in"
        "\nthe graph over that in trials; 95 % intervals by resampling the worlds.",
        not_reached(rows),
        disturbed(through_graph),
        delay_table({strategy: _stages(through_graph, strategy) for strategy in STRATEGIES}),
        _words_on_delays(through_graph),
    ]
    return "\n\n".join(parts)


def gain_table(rows: Sequence[dict]) -> str:
    """A line a family: arrivals, mean times and gains, over the worlds and seeds with which all four runs arrived."""
    times = [f"{strategy}, {kind} [s]" for kind, strategy in KINDS]
    heads = ["worlds", "reached, trial and graph", "compared", *times, "gain, trial [%]", "gain, graph [%]", "left [%]"]
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for family in (*FAMILIES, "all"):
        here = [row for row in rows if family in ("all", row["world"].partition(":")[0])]
        lines.append(f"| {' | '.join((family, *_gain_cells(here)))} |")
    return "\n".join(lines)


def _gain_cells(rows: Sequence[dict]) -> list[str]:
    by_kind = [[row["outcome"] == REACHED for row in rows if row["kind"] == kind] for kind in (TRIAL, GRAPH)]
    arrived = ", ".join(f"{sum(each)} of {len(each)}" for each in by_kind)
    times = _times(rows)
    compared = f"{sum(map(len, times))} in {len(times)} worlds"
    # over the worlds, as gains are
    means = np.mean([each.mean(axis=0) for each in times], axis=0).tolist() if times else [None] * len(KINDS)
    in_trials, in_graph = ([100.0 * (1.0 - each[:, k] / each[:, k + 1]) for each in times] for k in (0, 2))
    whole = level_of(MEAN, in_trials)
    above_zero = whole.low is not None and whole.low > 0.0
    left = share_of(in_graph, in_trials) if above_zero else Estimate(None, note="no gain that is surely above zero")
    gains = [with_interval(each, 1) for each in (whole, level_of(MEAN, in_graph))]
    return [arrived, compared, *(number(mean, 2) for mean in means), *gains, with_interval(left, 0)]


def _times(rows: Sequence[dict]) -> list[np.ndarray]:
    """(n, 4) arrival times [s] in each world, in the order of KINDS, with the n seeds with which all four arrived."""
    reached = {case_of(row): row["time"] for row in rows if row["outcome"] == REACHED}
    found: dict[str, list[list[float]]] = {}
    for world, seed in dict.fromkeys((row["world"], row["seed"]) for row in rows):
        four = [Case(world, seed, strategy, kind) for kind, strategy in KINDS]
        if all(case in reached for case in four):
            found.setdefault(world, []).append([reached[case] for case in four])
    return [np.array(each) for each in found.values()]


def not_reached(rows: Sequence[dict]) -> str:
    """How many runs did not arrive, and each of them with its outcome."""
    others = [f"{case_of(row)}: {row['outcome']}" for row in rows if row["outcome"] != REACHED]
    return "\n".join([f"{len(others)} of {len(rows)} runs did not arrive.", *others])


def disturbed(rows: Sequence[dict]) -> str:
    """How many of the runs through the graph a busy machine has disturbed, and each of them."""
    found = [row for row in rows if row.get("missed", 0) or row.get("lost", 0.0)]
    words = (
        f"{len(found)} of {len(rows)} runs through the graph were disturbed: a control period on the way was over"
        f" {LATE:g} times\nits own, or the simulator lost time in a stall."
    )
    named = [f"{case_of(row)}: {row['missed']} periods, {row['lost']:.3f} s lost" for row in found]
    return "\n".join([words, *named])


def _stages(rows: Sequence[dict], strategy: str) -> np.ndarray:
    """(n, len(STAGES)) what each stage took of the n plans of all runs with a strategy [ms]."""
    found = [stages for row in rows if row["strategy"] == strategy for stages in row.get("stages_ms", ())]
    return np.array(found).reshape(-1, len(STAGES))


def _words_on_delays(rows: Sequence[dict]) -> str:
    unread = [row for row in rows if row["unread"]]
    told = [row for row in rows if not row["unread"]]
    doubts = [row["doubt_ms"] for row in told if row["doubt_ms"] is not None]
    followed, plans = sum(len(row["stages_ms"]) for row in told), sum(row["plans"] for row in told)
    doubt = f"{np.median(doubts):.2f} ms" if doubts else "nobody knows what"
    in_trial = 1e3 * (CONTROLLER_PHASE - PLANNER_PHASE)
    words = [
        f"Of {followed} plans out of {plans}: the newest when a control period began, their messages all recorded.",
        f"A stage that begins by one clock and ends by the other, as from sending to taking, is known to {doubt}.",
        "When the robot takes a command is not recorded: the last line is how long the same message takes to bringup.",
        f"In a trial all of it takes {in_trial:.0f} ms, until the control period begins; after an impact maybe less.",
        f"Not in it: {len(unread)} runs whose recording cannot be read, {len(told) - len(doubts)} whose clocks cannot"
        " be compared.",
    ]
    return "\n".join([*words, *(f"{case_of(row)}: {row['unread']}" for row in unread)])
