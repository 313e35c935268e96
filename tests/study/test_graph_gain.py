"""The tables of tools/graph_gain.py, worked by hand on rows that are made up, and that a stop of it loses nothing."""

import json

import numpy as np
import pytest

import graph_gain
from collplan_core.evaluation.run_end import REACHED, STUCK
from collplan_study.analysis import statistics
from collplan_study.question import held_out
from graph_gain import cases, main
from graph_gain_report import (
    AGAINST,
    GRAPH,
    KINDS,
    OURS,
    TRIAL,
    Case,
    case_of,
    disturbed,
    gain_table,
    not_reached,
    report,
)
from plan_delays import STAGES

SAVED = {TRIAL: (10.0, 20.0, 30.0, 20.0, 10.0, 30.0), GRAPH: (5.0, 10.0, 15.0, 12.0, 4.0, 14.0)}
"""What OURS saves in each of six worlds [%]: 20 in the mean, and 10."""


@pytest.fixture(autouse=True)
def _quick(monkeypatch):
    monkeypatch.setattr(statistics, "RESAMPLES", 199)


def row(case, time, **measured):
    graphs = {"unread": "", "stages_ms": [], "doubt_ms": None, "plans": 0, "missed": 0, "lost": 0.0}
    return {**case._asdict(), "outcome": REACHED, "time": time, **(graphs if case.kind == GRAPH else {}), **measured}


def rows_of(family="serpentine", worlds=6):
    """AGAINST takes 10 s everywhere; a tenth of a second to and fro by seed, which leaves the means as they are."""
    for k in range(worlds):
        for seed, more in ((0, -0.1), (1, 0.1)):
            for kind, strategy in KINDS:
                time = 10.0 - 0.1 * SAVED[kind][k] + more if strategy == OURS else 10.0
                yield row(Case(f"{family}:{k}", seed, strategy, kind), time)


def cells(text, name):
    (line,) = (line for line in text.splitlines() if line.startswith(f"| {name} |"))
    return [cell.strip() for cell in line.strip("|").split("|")][1:]


def interval(cell):
    value, low, high = (float(part.strip("[],")) for part in cell.split())
    return value, low, high


def test_gains_and_what_is_left_of_them():
    table = gain_table(list(rows_of()))
    arrived, compared, *means, in_trials, in_graph, left = cells(table, "serpentine")
    assert (arrived, compared) == ("24 of 24, 24 of 24", "12 in 6 worlds")
    assert means == ["8.00", "10.00", "9.00", "10.00"]
    assert interval(in_trials)[0] == pytest.approx(20.0)
    assert interval(in_graph)[0] == pytest.approx(10.0)
    value, low, high = interval(left)
    assert value == pytest.approx(50.0)
    # no resample leaves the shares of single worlds, 40 to 60 %
    assert 40.0 <= low < 50.0 < high <= 60.0
    assert cells(table, "all") == cells(table, "serpentine")
    assert cells(table, "u")[:3] == ["0 of 0, 0 of 0", "0 in 0 worlds", "none"]


def test_a_graph_that_does_as_trials_do_leaves_all():
    rows = [each for each in rows_of() if each["kind"] == TRIAL]
    same = rows + [row(Case(each["world"], each["seed"], each["strategy"], GRAPH), each["time"]) for each in rows]
    assert cells(gain_table(same), "serpentine")[-1] == "100 (equal in each)"


def test_what_is_left_of_no_gain_is_not_told():
    rows = [each | {"time": 10.0 + 0.1 * each["seed"]} for each in rows_of()]
    assert "no gain that is surely above zero" in cells(gain_table(rows), "serpentine")[-1]


def test_few_worlds_give_no_interval():
    assert "4 of 5 needed" in cells(gain_table(list(rows_of(worlds=4))), "serpentine")[-3]


@pytest.mark.parametrize("kind", [TRIAL, GRAPH])
@pytest.mark.parametrize("strategy", [OURS, AGAINST])
def test_a_run_that_does_not_arrive_is_named_and_takes_those_beside_it_out(kind, strategy):
    lost = Case("serpentine:2", 1, strategy, kind)
    changed = {"outcome": STUCK, "time": 30.0 if kind == TRIAL else None}
    rows = [each | (changed if case_of(each) == lost else {}) for each in rows_of()]
    found = cells(gain_table(rows), "serpentine")
    assert found[0] == ("23 of 24, 24 of 24" if kind == TRIAL else "24 of 24, 23 of 24")
    assert found[1] == "11 in 6 worlds"
    assert not_reached(rows).splitlines() == ["1 of 48 runs did not arrive.", f"{lost}: stuck"]


def test_disturbed_runs_are_named():
    rows = [each for each in rows_of() if each["kind"] == GRAPH]
    assert disturbed(rows).startswith("0 of 24 runs")
    rows[3] |= {"missed": 2}
    rows[5] |= {"lost": 0.5}
    # what could not be read tells neither
    rows[7] = {key: rows[7][key] for key in (*Case._fields, "outcome", "time")} | {"unread": "no end"}
    words, *named = disturbed(rows).splitlines()[:1] + disturbed(rows).splitlines()[2:]
    assert words.startswith("2 of 24 runs")
    assert [line.partition(": ")[2] for line in named] == ["2 periods, 0.000 s lost", "0 periods, 0.500 s lost"]


def test_the_report_tells_of_every_plan_and_of_what_is_not_in_it():
    stages = np.arange(1.0, 1.0 + len(STAGES)).tolist()
    rows = list(rows_of())
    told, unread, without_clocks, *_ = (k for k, each in enumerate(rows) if each["kind"] == GRAPH)
    rows[told] |= {"stages_ms": [stages, stages], "doubt_ms": 0.25, "plans": 5}
    rows[unread] |= {"unread": "no end"}
    rows[without_clocks] |= {"plans": 4}
    text = report(rows)
    assert "Of 2 plans out of 9" in text
    assert "is known to 0.25 ms" in text
    assert "Not in it: 1 runs whose recording cannot be read, 22 whose clocks" in text
    assert f"{case_of(rows[unread])}: no end" in text
    # 1 + ... + 8 ms up to the command
    assert "| 36.0 | 36.0 | 36.0 |" in text


def test_worlds_are_not_held_out():
    asked = list(cases(worlds=12, seeds=3))
    assert len(set(asked)) == len(asked) == 2 * 12 * 3 * len(KINDS)
    seeds = {int(case.world.split(":")[1]) for case in asked}
    assert max(seeds) < 1000 < held_out.FIRST_SEED


def test_a_stop_loses_nothing_and_nothing_is_run_twice(monkeypatch, tmp_path, capsys):
    out, run = tmp_path / "runs" / "gain.jsonl", []

    def stopped_at(count):
        def made(case, folders):
            if len(run) == count:
                raise KeyboardInterrupt
            run.append(case)
            return row(case, 10.0)

        return made

    given = ["--out", str(out), "--worlds", "1", "--seeds", "1"]
    monkeypatch.setattr(graph_gain, "row_of", stopped_at(3))
    assert main(given) == 130
    monkeypatch.setattr(graph_gain, "row_of", stopped_at(None))
    assert main(given) == 0
    assert run == list(cases(worlds=1, seeds=1))
    assert [case_of(json.loads(line)) for line in out.read_text().splitlines()] == run
    capsys.readouterr()
    assert main([*given[:2], "--worlds", "0"]) == 0
    assert len(run) == 8
    assert "1 in 1 worlds" in capsys.readouterr().out
