"""A study stopped anywhere is completed to the table it would have made; a Dask cluster makes the same."""

import json
import shutil
import signal
from contextlib import closing

import polars as pl
import psutil
import pytest
from distributed import LocalCluster

from collplan_core.worlds import WorldError
from collplan_study.errors import StudyError
from collplan_study.main import main
from collplan_study.question.question import StudyOptions
from collplan_study.question.specification import ABLATIONS
from collplan_study.run import pools, provenance
from collplan_study.run.provenance import SIMULATOR, trial_code
from collplan_study.run.row_file import RowFile
from collplan_study.run.study_folder import ROWS, prepare, read_provenance, read_sources, read_study
from study_runs import GRID, N_TRIALS, n_rows, paths, resume, run, same, start, table, wait_for_rows

FEW = ["--strategies", "harness", "--map-periods", "0.2", "--trials", "2", "--jobs", "1", "--no-report"]
FEW += ["--set", "trial.timeout=1"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return run(tmp_path_factory.mktemp("whole") / "study", "--jobs", "1")


@pytest.fixture
def copy(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / "study")


def test_two_jobs_give_the_same_table_in_the_order_of_the_grid(whole, tmp_path):
    other = run(tmp_path / "study", "--jobs", "2")
    assert same(whole, other)
    assert table(whole).height == N_TRIALS
    order = [json.loads(line)["index"] for line in (other / ROWS).read_text().splitlines()]
    assert sorted(order) == list(range(N_TRIALS))


def trial_of(row):
    return tuple(row[name] for name in ("world", "strategy", "simulator.noise", "trial"))


def test_every_impact_has_its_row_and_a_deliberate_one_is_foreseen_and_fast(whole):
    of_trial: dict[tuple, list[dict]] = {}
    for impact in pl.read_parquet(whole / "impacts.parquet").to_dicts():
        of_trial.setdefault(trial_of(impact), []).append(impact)
        assert impact["deliberate"] == (impact["foreseen"] and impact["speed_into"] > 0.2)
    assert len(of_trial) > 3
    for row in table(whole).to_dicts():
        impacts = of_trial.get(trial_of(row), [])
        speeds = [impact["speed_into"] for impact in impacts]
        assert (len(speeds), max(speeds, default=0.0)) == (row["impacts"], row["max_impact_speed"])
        assert sum(impact["deliberate"] for impact in impacts) == row["deliberate_impacts"]
        assert sum(not impact["foreseen"] for impact in impacts) == row["unforeseen_impacts"]


def test_a_part_is_run_now_and_another_later(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", [".venv/bin/study"])
    folder = tmp_path / "my study"
    asked = [*FEW, "--ablations", "--ablation-trials", "1", "--worlds", "random:3", "--out", str(folder)]
    assert main([*asked, "--run", "main"]) == 0
    assert f".venv/bin/study --resume '{folder}'\n" in capsys.readouterr().out
    assert n_rows(folder) == table(folder).height == 2
    (folder / "trials.parquet").unlink()
    resume(folder, "--jobs", "1", "--run", "none")
    assert table(folder).height == 2
    resume(folder, "--jobs", "1", "--run", "ablations")
    done = [(row["ablation"], row["trial"]) for row in table(folder).to_dicts()]
    assert done == [("", 0), ("", 1), *((name, 0) for name in ABLATIONS if name)]


def killed_and_resumed(folder, jobs, count):
    process = start(folder, [*GRID, "--jobs", str(jobs)])
    wait_for_rows(folder, process, count)
    workers = psutil.Process(process.pid).children(recursive=True)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert psutil.wait_procs(workers, timeout=30.0)[1] == []
    assert n_rows(folder) < N_TRIALS
    return resume(folder, "--jobs", "1")


@pytest.mark.parametrize(("jobs", "count"), [(1, 1), *(pytest.param(2, n, marks=pytest.mark.soak) for n in (1, 4, 9))])
def test_a_killed_study_leaves_no_process_and_is_completed(whole, tmp_path, jobs, count):
    assert same(whole, killed_and_resumed(tmp_path / "study", jobs, count))


def test_a_last_line_cut_off_is_run_again(whole, copy):
    rows = (copy / ROWS).read_bytes()
    for kept in (rows[:-1], rows[:-700]):
        (copy / ROWS).write_bytes(kept)
        for name in ("trials.parquet", "trajectories.parquet"):
            (copy / name).unlink()
        assert same(whole, resume(copy, "--jobs", "1"))
        assert n_rows(copy) == N_TRIALS


def test_a_world_that_is_cut_off_anywhere_is_not_taken_for_another(whole, copy):
    path, provenance = copy / "worlds" / "0000.yaml", read_provenance(copy)
    written = path.read_bytes()
    assert len(read_sources(copy, provenance)) == len(provenance["sources"])
    for length in range(len(written)):
        path.write_bytes(written[:length])
        with pytest.raises(WorldError, match=r"0000\.yaml"):
            read_sources(copy, provenance)


def test_a_table_that_is_cut_off_is_refused_and_made_anew(whole, copy):
    for name in ("trials.parquet", "impacts.parquet"):
        held = (copy / name).read_bytes()
        for kept in (0, 1, len(held) // 2, -1, -9):
            (copy / name).write_bytes(held[:kept])
            with pytest.raises(StudyError, match="missing or cut off"):
                read_study(copy)
    assert same(whole, resume(copy, "--jobs", "1"))
    assert (copy / name).read_bytes() == held


def test_the_same_command_goes_on_and_another_one_is_refused(whole, copy, capsys):
    before = (copy / ROWS).read_bytes()
    assert main([*GRID, "--resume", str(copy), "--jobs", "1", "--no-report"]) == 0
    assert main(["--resume", str(copy), "--seed", "8"]) == 2
    assert "got 8" in capsys.readouterr().err
    assert (copy / ROWS).read_bytes() == before
    assert same(whole, copy)


def refused(capsys, folder):
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    assert main(["--resume", str(folder)]) == 2
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    error = capsys.readouterr().err
    assert len(error.splitlines()) == 1
    return error


def test_rows_that_are_none_or_of_another_study_are_named(copy, tmp_path, capsys):
    lines = (copy / ROWS).read_bytes().splitlines(keepends=True)
    for spoiled in (b"{}\n", b"garbage\n", lines[0], lines[4].replace(b'"seed":', b'"seed":1'), b"\x00\xff\n", b"[]\n"):
        (copy / ROWS).write_bytes(b"".join([*lines[:3], spoiled, *lines[4:]]))
        assert f"{ROWS}:4: got" in refused(capsys, copy)
    other = tmp_path / "other"
    assert main([*FEW, "--out", str(other)]) == 0
    capsys.readouterr()
    shutil.copy(other / ROWS, copy / ROWS)
    assert f"{ROWS}:1: got" in refused(capsys, copy)


def test_a_provenance_that_is_none_or_was_tampered_with_is_refused(copy, capsys):
    provenance = json.loads((copy / "provenance.json").read_text())
    parts = [("question", {"worlds": 3}), ("question", {"colour": 1}), ("sources", [{}]), ("ablations", 3)]
    whole = json.dumps(provenance)
    broken = ["", "{", whole[: len(whole) // 2], whole[:-3], "[]", '{"question": 1, "sources": 1, "code": {}}']
    for text in [*broken, *(json.dumps({**provenance, part: value}) for part, value in parts)]:
        (copy / "provenance.json").write_text(text)
        assert str(copy) in refused(capsys, copy)


def test_neither_other_code_nor_another_process_adds_rows_to_a_table(copy, capsys, monkeypatch):
    study = prepare(StudyOptions(resume=copy))
    with closing(RowFile(copy / ROWS, study.grid, study.provenance["code"]["trial"])):
        assert "another process" in refused(capsys, copy)
    monkeypatch.setattr("collplan_study.run.study_folder.trial_code", lambda: "0123456789abcdef")
    assert "other code" in refused(capsys, copy)


def test_a_row_of_other_code_is_refused_whenever_it_comes(copy, tmp_path, capsys, monkeypatch):
    rows = (copy / ROWS).read_text()
    for code in ('"code":"0123456789abcdef",', '"code":null,', ""):
        (copy / ROWS).write_text(rows.replace(f'"code":"{trial_code()}",', code))
        assert f"{ROWS}:1: run by other code" in refused(capsys, copy)
    monkeypatch.setattr(pools, "CODE", "0123456789abcdef")
    assert main([*FEW, "--out", str(tmp_path / "late")]) == 1
    assert "other code or libraries (0123456789abcdef) has joined" in capsys.readouterr().err
    assert n_rows(tmp_path / "late") == 0


def test_the_hash_of_the_code_is_that_of_its_files_and_their_places(tmp_path, monkeypatch):
    code = trial_code()
    copied = shutil.copytree(SIMULATOR, tmp_path / "omnipuck_sim", ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(provenance, "SIMULATOR", copied)
    codes = [trial_code()]
    assert codes == [code]
    with (copied / "trial.py").open("a", encoding="utf-8") as sources:
        sources.write("\nCHANGED = True\n")
    codes.append(trial_code())
    (copied / "robot" / "physics.py").rename(copied / "physics.py")
    codes.append(trial_code())
    assert len(set(codes)) == 3


def test_a_trial_that_raises_becomes_a_row_with_its_error_and_seed(tmp_path, monkeypatch, capsys):
    run_trial = pools.run_trial

    def failing(world, settings, seed):
        if settings.simulator.noise == 0.5:
            raise RuntimeError("the robot\nfell over")
        return run_trial(world, settings, seed)

    monkeypatch.setattr(pools, "run_trial", failing)
    folder = tmp_path / "study"
    assert main([*FEW, "--set", "simulator.noise=0.5,1", "--out", str(folder)]) == 1
    rows = [row for row in table(folder).to_dicts() if row["simulator.noise"] == 0.5]
    assert {(row["outcome"], row["error"]) for row in rows} == {("error", "RuntimeError: the robot fell over")}
    assert all(row["seed"] > 0 for row in rows)
    assert all(row["arrival_time_s"] is None for row in rows)
    assert [p["x"] for p in paths(folder).to_dicts() if p["simulator.noise"] == 0.5] == [[]] * len(rows)
    printed = capsys.readouterr()
    assert f"{len(rows)} error" in printed.out
    assert f"{len(rows)} trials were not run to their end: RuntimeError: the robot fell over" in printed.err


@pytest.mark.soak
@pytest.mark.parametrize(("stop", "code"), [("worker", 1), ("ctrl-c", 130)])
def test_a_lost_worker_or_ctrl_c_keeps_what_is_there(whole, tmp_path, stop, code):
    folder = tmp_path / "study"
    process = start(folder, [*GRID, "--jobs", "2"])
    wait_for_rows(folder, process, 4)
    study = psutil.Process(process.pid)
    if stop == "worker":
        (set(study.children(recursive=True)) - set(study.children())).pop().kill()
    else:
        process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60.0) == code
    assert same(whole, resume(folder, "--jobs", "1"))


@pytest.fixture(scope="module")
def cluster():
    with LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster:
        yield cluster


@pytest.mark.soak
def test_two_workers_give_the_same_table(cluster, tmp_path):
    assert same(run(tmp_path / "here", "--jobs", "1"), run(tmp_path / "there", "--dask", cluster.scheduler_address))


def test_workers_with_other_code_are_refused(cluster, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("collplan_study.run.provenance.SIMULATOR", tmp_path)
    assert main(["--dask", cluster.scheduler_address, "--out", str(tmp_path / "study")]) == 1
    assert "other code" in capsys.readouterr().err
    assert n_rows(tmp_path / "study") == 0
