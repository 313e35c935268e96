"""Trials on a Dask cluster, compared with those of one process."""

import pytest
from distributed import LocalCluster

from collplan_study.main import main
from study_runs import run, same


@pytest.fixture(scope="module")
def cluster():
    with LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster:
        yield cluster


@pytest.mark.soak
def test_two_workers_give_the_same_table(cluster, tmp_path):
    assert same(run(tmp_path / "here", "--jobs", "1"), run(tmp_path / "there", "--dask", cluster.scheduler_address))


def test_workers_with_other_code_are_refused(cluster, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("collplan_study.run.code_state.SIMULATOR", tmp_path)
    assert main(["--dask", cluster.scheduler_address, "--out", str(tmp_path / "study")]) == 2
    assert "other code" in capsys.readouterr().err
    assert not (tmp_path / "study").exists()
