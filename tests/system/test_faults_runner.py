"""The runner of `make faults`: a miss is a miss, a stall is repeated and counted, and nothing done is done again."""

import json
import math
from dataclasses import replace

import pytest

from faults.bench import BenchError
from faults.fault import Fault, Measured
from faults.runner import CaseFile, run_bench
from faults.stands import commanded_to_stand, why_followed_again
from faults.streams import Commanded, Motion, Placed, Said, Streams, WheelStop, longest_gap, why_lost
from faults.table import ROWS, STOPS, figures, largest_rate, seconds_taken, write

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
            raise BenchError("it does not drive")


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


def test_a_case_within_its_limit_is_none_and_one_beyond_it_is_a_miss(tmp_path):
    cases = done(tmp_path, fault(Measured(0.3), Measured(0.301), Measured(None)))
    assert [case.miss for case in cases] == ["", "after 0.301 s, limit 0.3 s", "never"]
    assert figures(fault(Measured()), cases)["misses"] == 2


def test_what_the_robot_must_not_do_is_a_miss_whatever_the_time(tmp_path):
    cases = done(tmp_path, fault(Measured(0.1, "it moved"), Measured(0.1), limit=None))
    assert [case.miss for case in cases] == ["it moved", "", ""]


def test_a_stall_is_no_miss_and_counted_and_the_case_repeated(tmp_path):
    cases = done(
        tmp_path, fault(Measured(0.9, stalled="0.5 s"), Measured(0.1), Measured(None, stalled="1 s"), Measured(0.2))
    )
    record = figures(fault(Measured()), cases)
    assert (record["n"], record["misses"], record["stalls"]) == (3, 0, 2)
    assert record["max_s"] == 0.2


def test_a_machine_that_only_stalls_does_not_go_on_for_ever(tmp_path):
    cases = done(tmp_path, fault(Measured(0.9, stalled="0.5 s")))
    assert 0 < len(cases) < 100
    assert not any(case.counts for case in cases)


def test_a_fault_that_could_not_be_seen_is_repeated_and_no_stall(tmp_path):
    cases = done(tmp_path, fault(Measured(None, unbegun="it stood already"), Measured(0.1)))
    record = figures(fault(Measured()), cases)
    assert (record["n"], record["misses"], record["stalls"], len(cases)) == (3, 0, 0, 4)


def test_a_failure_that_nobody_foresaw_is_a_miss_and_the_bench_is_opened_anew(tmp_path):
    broken = Fault("tipped", "puck", 0.3, lambda bench: {}["x"], lambda bench, begun: Measured(0.1))
    cases = done(tmp_path, broken)
    assert [case.miss for case in cases] == ["KeyError: 'x'"] * 3
    assert Bench.opened == 3


def test_cases_are_numbered_over_calls_and_none_has_the_chance_of_another(tmp_path):
    numbered = Fault("tipped", "puck", None, lambda bench: (bench.number, bench.chance.random()), lambda *_: Measured())
    drawn = []
    watched = replace(numbered, measure=lambda bench, act: drawn.append(act) or Measured())
    for n in (2, 3, 5):
        done(tmp_path, watched, n=n)
    assert [number for number, _ in drawn] == [0, 1, 2, 3, 4]
    assert len({chance for _, chance in drawn}) == 5


def test_what_was_done_is_not_done_again(tmp_path):
    done(tmp_path, fault(Measured(0.1)), n=2)
    assert len(done(tmp_path, fault(Measured(0.2)), n=5)) == 5
    assert len(done(tmp_path, fault(Measured(0.2)), n=5)) == 5


def test_what_another_state_of_the_code_has_done_does_not_count(tmp_path):
    done(tmp_path, fault(Measured(9.0)))
    file = CaseFile(tmp_path / "cases.jsonl", "newer")
    assert file.cases == []
    list(run_bench([fault(Measured(0.1))], Bench, lambda fault: 2, file, NEVER))
    assert len(CaseFile(tmp_path / "cases.jsonl", "newer").cases) == 2
    assert len(CaseFile(tmp_path / "cases.jsonl").cases) == 3


def test_rows_grow_alike_and_a_fault_is_undone_whatever_came_of_it(tmp_path):
    undone = []
    file = CaseFile(tmp_path / "cases.jsonl")
    faults = [fault(Measured(9.0), undone=undone), fault(Measured(0.1), undone=undone, name="lifted")]
    names = [case.fault for case in run_bench(faults, Bench, lambda fault: 2, file, NEVER)]
    assert names == ["tipped, puck", "lifted, puck"] * 2
    assert len(undone) == 4
    assert Bench.opened == 1


def test_a_bench_that_fails_once_is_opened_anew_and_one_that_fails_again_is_told(tmp_path):
    assert len(done(tmp_path, fault(Measured(0.1)), fails=1)) == 3
    Bench.opened = 0
    with pytest.raises(BenchError, match="does not drive"):
        done(tmp_path, fault(Measured(0.1)), n=9, fails=9)


def test_the_table_has_what_a_reader_of_figures_needs(tmp_path):
    tipped = fault(
        Measured(0.1, speed=1.0, distance=0.5), Measured(0.4, stalled="x"), Measured(0.2, speed=1.1, distance=0.4)
    )
    cases = done(tmp_path, tipped, n=20)
    for page, (begin, end) in (("safety.md", STOPS), ("page.md", ROWS)):
        (tmp_path / page).write_text(f"before {begin}\nold\n{end} after")
    faults = [tipped, fault(Measured(), name="never done")]
    write(faults, cases, tmp_path / "runs/faults.json", tmp_path / "page.md", tmp_path / "safety.md")
    record, other = json.loads((tmp_path / "runs/faults.json").read_text())
    assert record == {
        "fault": "tipped",
        "robot": "puck",
        "n": 20,
        "misses": 0,
        "stalls": 1,
        "limit_s": 0.3,
        "median_s": 0.2,
        "p99_s": None,
        "max_s": 0.2,
    }
    assert (other["fault"], other["n"]) == ("never done", 0)
    text = (tmp_path / "page.md").read_text()
    assert "| tipped | puck | 20 | 0 | 17 % | 1 | 0.3 | 0.2 |  | 0.2 | 0.50 from 1.10 m/s |" in text
    assert "| never done | puck | 0 | 0 |  | 0 |" in text
    assert text.startswith(f"before {ROWS[0]}\n20 of each row")
    assert text.endswith(f"{ROWS[1]} after")
    before, row, after = (
        (tmp_path / "safety.md").read_text().partition("| tipped | puck | 20 | 0.2 | 0.2 | 0.50 from 1.10 m/s |\n")
    )
    assert row
    assert before.startswith(f"before {STOPS[0]}\n| what |")
    assert after == f"{STOPS[1]} after"


def test_the_time_of_make_faults_is_that_of_the_first_cases_with_what_was_repeated(tmp_path):
    cases = [replace(case, took=1.0) for case in done(tmp_path, fault(Measured(0.1, stalled="x"), Measured(0.1)), n=22)]
    assert seconds_taken([fault(Measured())], cases) == 21.0


def test_a_percentile_is_told_from_five_hundred_cases_on(tmp_path):
    cases = done(tmp_path, fault(Measured(0.1)), n=1)
    assert figures(fault(Measured()), 499 * cases)["p99_s"] is None
    assert figures(fault(Measured()), 500 * cases)["p99_s"] == 0.1


@pytest.mark.parametrize(("misses", "n"), [(0, 20), (0, 100), (0, 500)])
def test_without_a_miss_the_upper_limit_is_that_of_the_textbook(misses, n):
    assert largest_rate(misses, n) == pytest.approx(1.0 - 0.025 ** (1.0 / n))


def test_the_zero_that_counts_is_the_one_that_only_zeros_follow():
    streams = Streams.__new__(Streams)
    streams.commands = [Commanded(0.05 * k, moves) for k, moves in enumerate([True, False, True, True, False, False])]
    assert streams.stands_from(0.0) == pytest.approx(0.2)
    assert streams.stands_from(0.22) == pytest.approx(0.25)
    streams.commands = streams.commands[:4]
    assert streams.stands_from(0.0) is None


class Heard:
    """A graph that has sent what a test says; the robot was told to stand at 0.2 s."""

    def __init__(self, refused: list[float]):
        self.streams = Streams.__new__(Streams)
        self.streams.commands = [Commanded(0.05 * k, k < 4) for k in range(-4, 20)]
        self.streams.truth = [Motion(0.0, 0.0, 0.0, 1.0), Motion(0.5, 0.3, 0.0, 0.0)]
        self.streams.poses = [Placed(0.01 * k, 0.0, 0.0) for k in range(-30, 0)]
        self.streams.refusals = [Said(sent, "yaw") for sent in refused]

    def until(self, condition, patience):
        return True

    def rest(self):
        pass


@pytest.mark.parametrize(
    ("refused", "stalled"),
    [
        ([0.01 * k for k in range(1, 40)], ""),
        ([0.01, *(0.01 * k for k in range(12, 40))], "mocap_node did not run for 0.11 s"),
        ([0.01, 0.23, 0.24], "mocap_node did not run for 0.22 s"),
        ([*(0.01 * k for k in range(1, 25)), 0.5], ""),
    ],
    ids=["no stall", "stalled before the stop", "stalled beyond the stop", "stalled after it"],
)
def test_a_motion_capture_that_stalls_while_it_sends_is_a_stall(refused, stalled):
    measured = commanded_to_stand(0.5, lambda graph, begun: refused[0])(Heard(refused), 0.0)
    assert (measured.seconds, measured.stalled) == (pytest.approx(0.19), stalled)


def test_poses_that_come_late_are_no_stall():
    graph = Heard([])
    graph.streams.poses += [Placed(0.15 + 0.01 * k, 0.0, 0.0) for k in range(9)]
    assert commanded_to_stand(0.5, lambda *_: 0.15)(graph, 0.0).stalled == ""


def test_a_gap_reaches_back_to_the_message_before():
    times = [0.0, 0.1, 0.2, 0.6, 0.7]
    assert longest_gap(times, 0.15, 0.3) == pytest.approx(0.1)
    assert longest_gap(times, 0.3, 0.65) == pytest.approx(0.4)
    assert longest_gap(times, 0.0, 1.0) == pytest.approx(0.4)
    assert longest_gap([], 0.0, 1.0) == 0.0


def test_a_robot_follows_again_where_wheels_turned_or_it_gained_speed():
    slowing = [Motion(0.01 * k, 0.0, 0.0, max(0.5 - 0.01 * k, 0.0)) for k in range(100)]
    faster = [*slowing[:30], *(Motion(0.3 + 0.01 * k, 0.0, 0.0, 0.2 + 0.02 * k) for k in range(10))]
    before, after = WheelStop(0.1, 3, 0.2, "life"), WheelStop(0.6, 4, 0.2, "life")
    assert why_followed_again([before], slowing, 0.2) == ""
    assert why_followed_again([before, after], slowing, 0.2) == "the wheels have turned again"
    assert "gained 0.18 m/s" in why_followed_again([before], faster, 0.2)
    assert why_followed_again([], [], 0.2) == ""


def test_the_firmware_stalls_by_what_its_own_clock_has_lost():
    losses = [(0.0, 0.5), (1.0, 0.51), (2.0, 0.7)]
    assert why_lost(losses, 0.5, 1.5) == ""
    assert why_lost(losses, 0.5, 2.5) == "the firmware did not run for 0.20 s"
    assert why_lost([], 0.5, 2.5) == ""
