"""A study stopped anywhere is completed to the table it would have made."""

import json
import shutil
import signal

import psutil
import pyarrow.parquet as pq
import pytest

from collplan_study.main import main
from collplan_study.question.ablations import ABLATIONS
from collplan_study.question.options import Options
from collplan_study.report import pictures
from collplan_study.run import preparation, worker
from collplan_study.run.row_file import RowFile
from collplan_study.run.study_folder import ROWS
from collplan_study.tables.columns import MEASURES
from study_runs import GRID, N_TRIALS, n_rows, paths, resume, run, same, start, table, wait_for_rows

FEW = ["--strategies", "harness", "--map-periods", "0.2", "--trials", "2", "--jobs", "1", "--no-report"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The study run at once in one process."""
    return run(tmp_path_factory.mktemp("whole") / "study", "--jobs", "1")


@pytest.fixture
def copy(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / "study")


def test_two_jobs_give_the_same_table_in_the_order_of_the_grid(whole, tmp_path):
    other = run(tmp_path / "study", "--jobs", "2")
    assert same(whole, other)
    assert table(whole).num_rows == N_TRIALS
    order = [json.loads(line)["index"] for line in (other / ROWS).read_text().splitlines()]
    assert sorted(order) == list(range(N_TRIALS))


def test_every_impact_has_its_row(whole):
    of_trial: dict[tuple, list[dict]] = {}
    for impact in pq.read_table(whole / "impacts.parquet").to_pylist():
        of_trial.setdefault(trial_of(impact), []).append(impact)
    assert len(of_trial) > 3
    for row in table(whole).to_pylist():
        impacts = of_trial.get(trial_of(row), [])
        speeds = [impact["speed_into"] for impact in impacts]
        assert (len(speeds), max(speeds, default=0.0)) == (row["impacts"], row["max_impact_speed"])
        assert sum(impact["deliberate"] for impact in impacts) == row["deliberate_impacts"]
        assert sum(not impact["foreseen"] for impact in impacts) == row["unforeseen_impacts"]


def test_a_deliberate_impact_is_foreseen_and_fast(whole):
    for impact in pq.read_table(whole / "impacts.parquet").to_pylist():
        assert impact["deliberate"] == (impact["foreseen"] and impact["speed_into"] > 0.2)


def trial_of(row):
    return tuple(row[name] for name in ("world", "strategy", "simulator.noise", "trial"))


def test_a_part_is_run_now_and_another_later(tmp_path):
    folder = tmp_path / "study"
    asked = [*FEW, "--ablations", "--ablation-trials", "1", "--worlds", "random:3", "--out", str(folder)]
    assert main([*asked, "--run", "main"]) == 0
    assert n_rows(folder) == table(folder).num_rows == 2
    (folder / "trials.csv").unlink()
    resume(folder, "--jobs", "1", "--run", "none")
    assert len((folder / "trials.csv").read_text().splitlines()) == 3
    resume(folder, "--jobs", "1", "--run", "ablations")
    done = [(row["ablation"], row["trial"]) for row in table(folder).to_pylist()]
    assert done == [("", 0), ("", 1), *((name, 0) for name in ABLATIONS if name)]


def test_what_completes_a_study_works_from_where_the_user_stands(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", [".venv/bin/study"])
    folder = tmp_path / "my study"
    assert main([*FEW, "--worlds", "random:3", "--run", "none", "--out", str(folder)]) == 0
    said = capsys.readouterr().out
    assert f"2 trials were not run; complete it with: .venv/bin/study --resume '{folder}'\n" in said
    assert "report" not in said


def test_where_the_report_is_is_said(copy, monkeypatch, capsys):
    monkeypatch.setattr(pictures, "save_figure", lambda figure, stem: "<svg/>")
    assert main(["--resume", str(copy), "--jobs", "1", "--run", "none"]) == 0
    assert f"report: {copy / 'report.html'}\n" in capsys.readouterr().out
    assert (copy / "report.html").is_file()


def killed_and_resumed(folder, jobs, count):
    process = start(folder, [*GRID, "--jobs", str(jobs)])
    wait_for_rows(folder, process, count)
    workers = psutil.Process(process.pid).children(recursive=True)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert psutil.wait_procs(workers, timeout=30.0)[1] == []
    assert n_rows(folder) < N_TRIALS
    return resume(folder, "--jobs", "1")


@pytest.mark.parametrize(("jobs", "count"), [(1, 1), pytest.param(2, 9, marks=pytest.mark.soak)])
def test_a_killed_study_leaves_no_process_and_is_completed(whole, tmp_path, jobs, count):
    assert same(whole, killed_and_resumed(tmp_path / "study", jobs, count))


@pytest.mark.soak
@pytest.mark.parametrize("count", [1, 2, 4, 5, 8, 9, 12, 16, 20, 24])
def test_a_study_killed_anywhere_is_completed(whole, tmp_path, count):
    assert same(whole, killed_and_resumed(tmp_path / "study", 2, count))


@pytest.mark.parametrize("cut", [1, 2, 700, "no row", "no file"])
def test_a_last_line_cut_off_is_run_again(whole, copy, cut):
    rows = (copy / ROWS).read_bytes()
    if cut == "no file":
        keep = rows.splitlines(keepends=True)[:-3]
        (copy / ROWS).write_bytes(b"".join(keep))
    else:
        (copy / ROWS).write_bytes(rows[: rows.index(b"\n") - 5] if cut == "no row" else rows[:-cut])
    for name in ("trials.parquet", "trials.csv", "trajectories.parquet"):
        (copy / name).unlink()
    assert same(whole, resume(copy, "--jobs", "1"))
    assert n_rows(copy) == N_TRIALS


def test_the_same_command_goes_on_and_another_one_is_refused(whole, copy, capsys):
    before = (copy / ROWS).read_bytes()
    assert main([*GRID, "--resume", str(copy), "--jobs", "1", "--no-report"]) == 0
    assert main(["--resume", str(copy), "--seed", "8"]) == 2
    assert "another study, its seed is 7, got 8" in capsys.readouterr().err
    assert (copy / ROWS).read_bytes() == before
    assert same(whole, copy)


def test_a_world_file_may_change_or_go_once_the_study_has_begun(tmp_path, whole):
    world = tmp_path / "mine.yaml"
    shutil.copy(whole / "worlds" / "0000.yaml", world)
    folder = tmp_path / "study"
    assert main([*FEW, "--worlds", str(world), "--out", str(folder)]) == 0
    before = table(folder)
    world.unlink()
    (folder / ROWS).unlink()
    resume(folder, "--jobs", "1")
    assert table(folder).equals(before)


def refused(capsys, folder):
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    assert main(["--resume", str(folder)]) == 2
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    error = capsys.readouterr().err
    assert len(error.splitlines()) == 1
    return error


def test_a_line_that_is_no_row_is_named(copy, capsys):
    lines = (copy / ROWS).read_bytes().splitlines(keepends=True)
    for spoiled in (b"{}\n", b"garbage\n", lines[0], lines[4].replace(b'"seed":', b'"seed":1'), b"\x00\xff\n", b"[]\n"):
        (copy / ROWS).write_bytes(b"".join([*lines[:3], spoiled, *lines[4:]]))
        assert f"{ROWS}:4: got" in refused(capsys, copy)


def test_rows_of_another_study_are_refused(copy, tmp_path, capsys):
    other = tmp_path / "other"
    assert main([*FEW, "--out", str(other)]) == 0
    capsys.readouterr()
    shutil.copy(other / ROWS, copy / ROWS)
    assert f"{ROWS}:1: got" in refused(capsys, copy)


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", '{"question": 1, "sources": 1, "ablations": 1, "code": {}}'])
def test_a_folder_that_is_no_study_is_refused(copy, capsys, text):
    (copy / "provenance.json").write_text(text)
    assert "provenance.json" in refused(capsys, copy)


@pytest.mark.parametrize(
    ("part", "value"), [("question", {"worlds": 3}), ("question", {"colour": 1}), ("sources", [{}]), ("ablations", 3)]
)
def test_a_provenance_that_was_tampered_with_is_refused(copy, capsys, part, value):
    provenance = json.loads((copy / "provenance.json").read_text())
    (copy / "provenance.json").write_text(json.dumps({**provenance, part: value}))
    assert str(copy) in refused(capsys, copy)


def test_other_code_does_not_add_rows_to_a_table(copy, capsys, monkeypatch):
    monkeypatch.setattr("collplan_study.run.provenance.trial_code", lambda: "0123456789abcdef")
    assert "begun with other code" in refused(capsys, copy)


def test_two_processes_do_not_work_on_one_study(copy, capsys):
    grid = preparation.prepare(Options(resume=copy)).grid
    with RowFile(copy / ROWS, grid):
        assert "another process" in refused(capsys, copy)


def test_a_trial_that_raises_becomes_a_row_with_its_error_and_seed(tmp_path, monkeypatch, capsys):
    run_trial = worker.run_trial

    def failing(world, settings, seed):
        if settings.simulator.noise == 0.5:
            raise RuntimeError("the robot\nfell over")
        return run_trial(world, settings, seed)

    monkeypatch.setattr(worker, "run_trial", failing)
    folder = run(tmp_path / "study", "--jobs", "1")
    rows = [row for row in table(folder).to_pylist() if row["simulator.noise"] == 0.5]
    assert {row["outcome"] for row in rows} == {"error"}
    assert {row["error"] for row in rows} == {"RuntimeError: the robot fell over"}
    assert all(row["seed"] > 0 for row in rows)
    measured = set(MEASURES) & set(rows[0]) - {"outcome", "error"}
    assert all(row[name] is None for row in rows for name in measured)
    assert [p["x"] for p in paths(folder).to_pylist() if p["simulator.noise"] == 0.5] == [[]] * (N_TRIALS // 2)
    assert f"{N_TRIALS // 2} error" in capsys.readouterr().out


@pytest.mark.soak
def test_a_lost_worker_stops_the_study_which_is_completed_later(whole, tmp_path):
    folder = tmp_path / "study"
    process = start(folder, [*GRID, "--jobs", "2"])
    wait_for_rows(folder, process, 4)
    study = psutil.Process(process.pid)
    (set(study.children(recursive=True)) - set(study.children())).pop().kill()
    assert process.wait(timeout=60.0) == 1
    assert same(whole, resume(folder, "--jobs", "1"))


@pytest.mark.soak
def test_ctrl_c_keeps_what_is_there(whole, tmp_path):
    folder = tmp_path / "study"
    process = start(folder, [*GRID, "--jobs", "2"])
    wait_for_rows(folder, process, 4)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60.0) == 130
    assert same(whole, resume(folder, "--jobs", "1"))
