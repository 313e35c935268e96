"""The studies behind docs/results.md: all can be asked, in held-out worlds, and what is complete is not run again."""

import pytest

import results
from collplan_study.question import held_out
from collplan_study.question.question import parse
from collplan_study.run.study_folder import ROWS
from results import BARN, PARTS, Part, main


def test_every_study_is_a_question_and_their_time_is_three_hours_at_most():
    parts = {**PARTS, **BARN}
    asked = {
        name: parse([*part.options, "--seed", str(held_out.STUDY_SEED)]).question() for name, part in parts.items()
    }
    assert {question.seed for question in asked.values()} == {held_out.STUDY_SEED}
    for question in (asked["bounces"], asked["bounces_mujoco"]):
        assert question.worlds == tuple(map(held_out.held_out_worlds, (*held_out.FAMILIES, *held_out.FURTHER_FAMILIES)))
    assert sum(part.minutes for part in parts.values()) <= 180


def test_a_study_is_run_once_completed_where_rows_are_missing_and_unknown_names_are_refused(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(results, "OUT", tmp_path)
    monkeypatch.setattr(results, "PARTS", {"small": Part(0.1, ("--worlds", "floor", "--trials", "1", "--jobs", "1"))})
    assert main([]) == 0
    rows = tmp_path / "small" / ROWS
    complete = rows.read_text().splitlines()
    rows.write_text("\n".join(complete[:-2]) + "\n")
    assert main(["small"]) == 0
    assert len(rows.read_text().splitlines()) == len(complete)
    ran = rows.read_text()
    assert main([]) == 0
    assert rows.read_text() == ran
    with pytest.raises(SystemExit):
        main(["barn"])
    assert "--barn DIR" in capsys.readouterr().err
