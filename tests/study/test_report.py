"""table.json and report.html of made-up studies: right numbers, incomplete studies, a page without external files."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from collplan_core.worlds import load_world
from collplan_study.analysis import statistics
from collplan_study.analysis.results import OPPOSITE
from collplan_study.question.grid import Source
from collplan_study.question.question import Question
from collplan_study.question.specification import ABLATIONS
from collplan_study.report.write_report import write_report
from fake_studies import failed, fake_study, reached, timed_out, without_figures

SMALL = Question(trials=6, map_periods=(0.2,))
ABLATED = {name: ABLATIONS[name] for name in ("", "without R_ref", "a_max 3 m/s^2")}
FASTER = {"harness": 0.9, "high_risk": 1.0, "low_risk": 1.2}


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    without_figures(monkeypatch)


def by_strategy(task):
    """harness 10 % faster than high_risk, a quarter faster than low_risk, in every pair."""
    noise = np.random.default_rng(task.seed).normal(3.0, 0.2)
    return reached(FASTER[task.labels["strategy"]] * noise)


def report_of(folder):
    write_report(folder)
    return json.loads((folder / "table.json").read_text()), (folder / "report.html").read_text()


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(statistics, "RESAMPLES", 499)
        folder = fake_study(tmp_path_factory.mktemp("plain") / "study", by_strategy, Question(trials=6))
        write_report(folder)
    return folder


def test_table_one_has_the_improvements_beside_the_papers(plain):
    found = json.loads((plain / "table.json").read_text())
    assert found["comparisons"] == {"main": 8, "other_map_periods": 32, "changes": 0}
    assert "40 comparisons" in (plain / "report.html").read_text()
    case = found["cases"][0]
    rows = {(row["other"], row["column"], row["measure"]): row for row in case["comparisons"]}
    assert len(rows) == len(case["comparisons"]) == 8
    time = rows["high_risk", "arrival_time_s", "mean"]
    assert time["estimate"]["value"] == pytest.approx(10.0)
    assert (time["paper"], time["pairs"], time["map_period"]) == (7.6, 6, 0.2)
    assert rows["low_risk", "arrival_time_s", "std"]["estimate"]["value"] == pytest.approx(25.0)
    assert rows["low_risk", "path_length_m", "mean"]["verdict"] == OPPOSITE
    assert [row["paper"] for row in case["comparisons"]] == [7.60, 3.48, 2.32, 0.99, 8.53, 2.39, 16.01, 0.47]


def test_the_page_needs_nothing_but_itself_and_figures_are_files_too(plain):
    text = (plain / "report.html").read_text()
    assert text.count("<img") == 1
    assert not re.search(r"<(script|iframe|object|embed)|url\(|@import", text)
    addresses = re.findall(r"""\b(?:src|href|srcset|data|action)=["']?([^"'\s>]+)""", text)
    assert addresses
    assert all(address.startswith("data:") for address in addresses)
    asked = re.search(r"<td>asked<td>(.*?)\n", text)[1]
    assert '"trials": 6' in asked
    stems = {path.stem for path in (plain / "figures").iterdir()}
    assert stems == {"corridor-paths"}
    for stem in stems:
        assert (plain / "figures" / f"{stem}.png").read_bytes().startswith(b"\x89PNG")
        assert not re.search(r'href="[^#]', (plain / "figures" / f"{stem}.svg").read_text())


def test_runs_that_do_not_arrive_count_with_the_limit_and_are_listed(tmp_path):
    def one_late(task):
        return timed_out() if task.labels["strategy"] == "harness" and task.labels["trial"] == 0 else by_strategy(task)

    found, page = report_of(fake_study(tmp_path / "study", one_late, SMALL))
    harness = found["cases"][0]["cells"][0]
    assert harness["outcomes"] == {"reached": 5, "timeout": 1, "stuck": 0, "aborted": 0, "error": 0}
    assert harness["success"]["value"] == pytest.approx(100 * 5 / 6)
    assert harness["levels"][0]["value"] > 30.0 / 6
    assert "1 of 18:" in page


def test_studies_with_little_in_them_have_their_report(tmp_path):
    for measures in (timed_out, failed):
        found, page = report_of(fake_study(tmp_path / measures.__name__, lambda task, m=measures: m(), SMALL))
        assert all(row["estimate"]["low"] is None for row in found["cases"][0]["comparisons"])
        assert "18 of 18:" in page
    found, page = report_of(fake_study(tmp_path / "one", by_strategy, Question(trials=1, map_periods=(0.4,))))
    first = found["cases"][0]["comparisons"][0]
    assert (first["map_period"], first["estimate"]["low"]) == (0.4, None)
    assert "1 of 5 needed" in page
    for strategies in (("low_risk",), ("high_risk", "low_risk")):
        folder = fake_study(tmp_path / "-".join(strategies), by_strategy, replace(SMALL, strategies=strategies))
        found, page = report_of(folder)
        assert [row["paper"] for row in found["cases"][0]["comparisons"]] == [None] * 4 * (len(strategies) - 1)
        assert ("nothing to compare" in page) == (len(strategies) == 1)


def test_worlds_of_a_family_are_resampled_and_points_of_an_axis_kept_apart(tmp_path):
    question = Question(("random:0-5",), trials=1, map_periods=(0.2,), values=("robot.max_acceleration=1.5,3",))
    found, page = report_of(fake_study(tmp_path / "study", by_strategy, question))
    assert [case["case"]["name"] for case in found["cases"]] == [
        "random, robot.max_acceleration = 1.5",
        "random, robot.max_acceleration = 3.0",
    ]
    assert found["cases"][0]["comparisons"][0]["pairs"] == 6
    assert "in 3 of 6 worlds" in page


def test_names_from_files_stay_text(tmp_path):
    world = replace(load_world("corridor"), name="<script>alert(1)</script>/..")
    _, page = report_of(fake_study(tmp_path / "study", by_strategy, SMALL, (Source(world, world.name),)))
    assert "<script>" not in page


def test_the_table_of_ablations_says_what_a_change_costs(tmp_path):
    def slower_without(task):
        time = 3.0 + 0.1 * task.labels["trial"]
        return reached(time * (1.25 if task.labels["ablation"] == "without R_ref" else 1.0))

    question = Question(trials=6, map_periods=(0.2,), ablations=True)
    folder = fake_study(tmp_path / "study", slower_without, question, ablations=ABLATED)
    found, page = report_of(folder)
    assert len(found["cases"]) == 1
    assert [row["ablation"] for row in found["changes"]] == ["without R_ref", "a_max 3 m/s^2"]
    saved = [[cell["saved_by_change"]["value"] for cell in row["cells"]] for row in found["changes"]]
    assert saved == [pytest.approx([-25.0] * 3), [0.0] * 3]
    assert found["comparisons"]["changes"] == 4
    assert "without R_ref" in page
