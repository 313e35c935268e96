"""The command `make rivals`: other planners on the same disc with the same map, beside bounce and avoid.

OMPL's SST plans for 1 and for 10 s, and its best plan is followed. pytorch_mppi plans anew every 0.05 s. A row that is
there is not run again; to run it again, delete its line. Ctrl-C ends in order, and the next call goes on. Simulated.
"""

import argparse
import sys
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from collplan_core.evaluation.run_end import REACHED
from collplan_study.run.row_file import JsonLines
from markdown_text import Section, markdown
from rivals.runs import OPTIMUM, RIVALS, WORLDS, Case, cases, figures


def main(args: Sequence[str] | None = None) -> int:
    """Runs what is not there yet, and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("runs/rivals.jsonl"), help="rows, one run a line")
    parser.add_argument("--worlds", type=int, default=8, help="worlds of each family at most (default 8)")
    given = parser.parse_args(args)
    out = JsonLines(given.out)
    known = {Case(row["world"], row["who"]): row for row in out.records()}
    wanted = list(cases(given.worlds))
    try:
        for case in (each for each in wanted if each not in known):
            known[case] = {**case._asdict(), **figures(case)}
            out.append(known[case])
            print(f"{case.world}, {case.who}: {known[case].get('outcome', 'found')}", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print("interrupted: the next call goes on", file=sys.stderr)
        return 130
    print(markdown(table_of([known[case] for case in wanted])))
    return 0


def table_of(rows: Sequence[dict[str, Any]]) -> Section:
    """The table of all rows."""
    best = {row["world"]: row["time"] for row in rows if row["who"] == OPTIMUM}
    families = [
        (family, who, [row for row in rows if row["who"] == who and row["world"].startswith(family)])
        for family, who in product(WORLDS, RIVALS)
    ]
    return Section(
        "Rivals on the same disc",
        "Known map, noise of the study of bounces, one run a world. Times are over that of the best trajectory without "
        "contact, of the runs that arrived: mean [least, greatest]. Planned: the time that SST foresaw. "
        "Planning: the processor's time.",
        ("", "arrived", "time / best", "planned / best", "contacts a run", "planning p50 [ms]", "p99 [ms]"),
        [(f"{family}, {who}", *cells(runs, best)) for family, who, runs in families if runs],
    )


def cells(runs: Sequence[dict[str, Any]], best: dict[str, float]) -> list[str]:
    """Returns the cells of the table for the runs of one rival in one family."""
    there = [row for row in runs if row["outcome"] == REACHED]
    driven, planned = ([row[key] / best[row["world"]] for row in there if key in row] for key in ("time", "planned"))
    planning = np.concatenate([row["planning_ms"] for row in runs])
    numbers = np.mean([row["contacts"] for row in runs]), *np.quantile(planning, (0.5, 0.99))
    return [f"{len(there)} of {len(runs)}", _range(driven), _range(planned), *(f"{each:.1f}" for each in numbers)]


def _range(values: Sequence[float]) -> str:
    return f"{np.mean(values):.3f} [{min(values):.3f}, {max(values):.3f}]" if values else ""


if __name__ == "__main__":
    sys.exit(main())
