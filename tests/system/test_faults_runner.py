"""The runner of `make faults`: a miss is a miss, and a stall is repeated and counted."""

import math

from faults.bench import Bench
from faults.fault import Fault, Measured
from faults.runner import CaseFile, run_bench
from faults.table import figures


def fault(*measured: Measured, limit: float | None = 0.3) -> Fault:
    """A fault that gives these results in turn, the last one for ever."""
    left = list(measured)

    def measure(bench, begun):
        return left.pop(0) if len(left) > 1 else left[0]

    return Fault("tipped", "puck", limit, lambda bench: 0.0, measure, lambda bench: None)


def done(path, fault: Fault):
    file = CaseFile(path / "cases.jsonl")
    list(run_bench([fault], Bench, lambda fault: 3, file, math.inf))
    return file.cases


def test_what_a_case_counts_as(tmp_path):
    stalls, fails = Measured(0.9, stalled="0.5 s"), Measured(0.1, "moved")
    broken = Fault("tipped", "puck", 0.3, lambda bench: {}["x"], lambda bench, begun: Measured(0.1))
    table = {
        "within, beyond, never": (fault(Measured(0.3), Measured(0.301), Measured(None)), 2, 0, 3),
        "forbidden": (fault(fails, Measured(0.1), limit=None), 1, 0, 3),
        "stalls are repeated": (fault(stalls, Measured(0.1), stalls, Measured(0.2)), 0, 2, 5),
        "not seen": (fault(Measured(None, unbegun="stood"), Measured(0.1)), 0, 0, 4),
        "unforeseen": (broken, 3, 0, 3),
    }
    for number, (name, (each, misses, n_stalls, n_cases)) in enumerate(table.items()):
        (tmp_path / str(number)).mkdir()
        cases = done(tmp_path / str(number), each)
        record = figures(fault(Measured()), cases)
        assert (record["n"], record["misses"], record["stalls"], len(cases)) == (3, misses, n_stalls, n_cases), name
    only_stalls = done(tmp_path, fault(stalls))
    assert 0 < len(only_stalls) < 100
    assert not any(case.counts for case in only_stalls)
