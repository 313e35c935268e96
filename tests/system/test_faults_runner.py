"""The runner of `make faults`: a miss is a miss, a stall is repeated and counted, and nothing done is done again."""

import json
import math
from dataclasses import replace

import pytest

from faults.bench import BenchError
from faults.fault import Fault, Measured
from faults.runner import CaseFile, run_bench
from faults.streams import longest_gap
from faults.table import ROWS, STOPS, figures, largest_rate, write

NEVER = math.inf
UNNOTICED: list[int] = []


class Bench:
    """A bench that counts how often it was opened."""

    opened = 0

    def __init__(self, fails: int = 0):
        self.fails = fails

    def __enter__(self):
        Bench.opened += 1
        return self

    def __exit__(self, *_):
        pass

    def drive(self):
        if Bench.opened <= self.fails:
            raise BenchError("stands")


@pytest.fixture(autouse=True)
def _unopened(monkeypatch):
    monkeypatch.setattr(Bench, "opened", 0)


def fault(*measured: Measured, limit: float | None = 0.3, undone: list = UNNOTICED, name: str = "tipped") -> Fault:
    """A fault that gives these results in turn, the last one for ever."""
    left = list(measured)

    def measure(bench, begun):
        return left.pop(0) if len(left) > 1 else left[0]

    return Fault(name, "puck", limit, lambda bench: 0.0, measure, lambda bench: undone.append(1))


def done(path, *faults: Fault, n: int = 3, fails: int = 0):
    file = CaseFile(path / "cases.jsonl")
    list(run_bench(faults, lambda: Bench(fails), lambda fault: n, file, NEVER))
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


def test_rows_grow_alike_are_undone_and_never_done_twice_or_by_other_code(tmp_path):
    undone = []
    file = CaseFile(tmp_path / "cases.jsonl")
    faults = [fault(Measured(9.0), undone=undone), fault(Measured(0.1), undone=undone, name="lifted")]
    names = [case.fault for case in run_bench(faults, Bench, lambda fault: 2, file, NEVER)]
    assert names == ["tipped, puck", "lifted, puck"] * 2
    assert (len(undone), Bench.opened) == (4, 1)
    for _ in range(2):
        assert len(done(tmp_path, fault(Measured(0.2)), n=5)) == 5 + 2
    assert CaseFile(tmp_path / "cases.jsonl", "newer").cases == []
    drawn = []
    numbered = Fault("drawn", "puck", None, lambda bench: (bench.number, bench.chance.random()), lambda *_: Measured())
    watched = replace(numbered, measure=lambda bench, act: drawn.append(act) or Measured())
    for n in (2, 3, 5):
        done(tmp_path, watched, n=n)
    assert [number for number, _ in drawn] == [0, 1, 2, 3, 4]
    assert len({chance for _, chance in drawn}) == 5


def test_a_bench_that_fails_once_is_opened_anew_and_one_that_fails_again_is_told(tmp_path):
    assert len(done(tmp_path, fault(Measured(0.1)), fails=1)) == 3
    Bench.opened = 0
    with pytest.raises(BenchError, match="stands"):
        done(tmp_path, fault(Measured(0.1)), n=9, fails=9)


def test_the_table_has_what_a_reader_of_figures_needs(tmp_path):
    measured = (
        Measured(0.1, speed=1.0, distance=0.5),
        Measured(0.4, stalled="x"),
        Measured(0.2, speed=1.1, distance=0.4),
    )
    tipped = fault(*measured)
    cases = done(tmp_path, tipped, n=20)
    for page, (begin, end) in (("safety.md", STOPS), ("page.md", ROWS)):
        (tmp_path / page).write_text(f"before {begin}\nold\n{end} after")
    write(
        [tipped, fault(Measured(), name="never")],
        cases,
        tmp_path / "f.json",
        tmp_path / "page.md",
        tmp_path / "safety.md",
    )
    record, other = json.loads((tmp_path / "f.json").read_text())
    assert (record["n"], record["misses"], record["stalls"], record["median_s"], record["max_s"]) == (
        20,
        0,
        1,
        0.2,
        0.2,
    )
    assert (other["fault"], other["n"]) == ("never", 0)
    text = (tmp_path / "page.md").read_text()
    assert "| tipped | puck | 20 | 0 | 17 % | 1 | 0.3 | 0.2 |  | 0.2 | 0.50 from 1.10 m/s |" in text
    assert text.startswith("before ")
    assert text.endswith(f"{ROWS[1]} after")
    assert "| tipped | puck | 20 | 0.2 | 0.2 | 0.50 from 1.10 m/s |\n" in (tmp_path / "safety.md").read_text()
    case = cases[:1]
    assert [figures(tipped, n * case)["p99_s"] for n in (499, 500)] == [None, 0.1]


def test_formulas():
    for n in (20, 100, 500):
        assert largest_rate(0, n) == pytest.approx(1.0 - 0.025 ** (1.0 / n))
    times = [0.0, 0.1, 0.2, 0.6, 0.7]
    assert longest_gap(times, 0.15, 0.3) == pytest.approx(0.1)
    assert longest_gap(times, 0.3, 0.65) == longest_gap(times, 0.0, 1.0) == pytest.approx(0.4)
    assert longest_gap([], 0.0, 1.0) == 0.0
