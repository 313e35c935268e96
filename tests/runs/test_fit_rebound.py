"""fit_rebound on run folders of a simulated robot whose rebounds are not those that the planner believes."""

import csv
import json
import shutil

import pytest

from bumping_runs import bumping_run
from collplan_core.parameters.file import read_parameters, write_values
from collplan_ros.runs.fit_rebound import main
from collplan_ros.runs.impact_log import COLUMNS

WRITTEN, REFUSED = 0, 2


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A run of three quarters of a minute, restitution 0.55 and retention 0.75 in truth."""
    return bumping_run(
        tmp_path_factory.mktemp("runs"), 45.0, simulator__restitution=0.55, simulator__tangential_retention=0.75
    )


@pytest.fixture
def run(recorded, tmp_path):
    """A copy of it to spoil."""
    return shutil.copytree(recorded, tmp_path / "run")


def fitted(*folders, out, options=()):
    return main([*map(str, folders), "--out", str(out), *options])


@pytest.mark.parametrize(("restitution", "retention"), [(0.55, 0.8), (0.85, 0.6)])
def test_the_truth_is_found_not_the_belief(tmp_path, capsys, restitution, retention):
    truth = {"simulator__restitution": restitution, "simulator__tangential_retention": retention}
    folders = [bumping_run(tmp_path / "runs", 25.0, seed, **truth) for seed in (0, 1)]
    out = tmp_path / "rebound.yaml"
    assert fitted(*folders, out=out) == WRITTEN, capsys.readouterr().err
    found = read_parameters(out)
    assert found["rebound.restitution"] == pytest.approx(restitution, abs=0.03)
    assert found["rebound.tangential_retention"] == pytest.approx(retention, abs=0.05)
    assert len(found) == 2
    said = capsys.readouterr().out
    assert "2 simulated runs" in said
    assert str(out) in said
    comment = out.read_text().split("/**")[0]
    assert all(str(folder) in comment for folder in folders)
    assert "simulated" in comment
    assert "95 % interval" in comment


def test_only_measured_poses_and_commands_count(run, tmp_path):
    """impacts.csv, which a simulator fills with the truth, may say what it wants."""
    assert fitted(run, out=tmp_path / "with.yaml") == WRITTEN
    (run / "impacts.csv").write_text(",".join(COLUMNS) + "\n")
    assert fitted(run, out=tmp_path / "without.yaml") == WRITTEN
    assert read_parameters(tmp_path / "with.yaml") == read_parameters(tmp_path / "without.yaml")


def test_a_run_given_twice_counts_once(run, tmp_path, capsys):
    (tmp_path / "latest").symlink_to(run)
    assert fitted(run, tmp_path / "latest", out=tmp_path / "o.yaml") == WRITTEN
    assert "1 simulated run:" in capsys.readouterr().out


def test_the_other_values_of_a_file_are_taken_over(run, tmp_path):
    write_values({"robot.mass": 0.9, "rebound.restitution": 0.1}, tmp_path / "lab.yaml")
    out = tmp_path / "o.yaml"
    assert fitted(run, out=out, options=["--params", str(tmp_path / "lab.yaml")]) == WRITTEN
    values = read_parameters(out)
    assert values["robot.mass"] == 0.9
    assert values["rebound.restitution"] == pytest.approx(0.55, abs=0.05)


def test_a_file_is_replaced_only_by_force(run, tmp_path, capsys):
    out = tmp_path / "o.yaml"
    out.write_text("mine")
    assert fitted(run, out=out) == REFUSED
    assert f"--out {out}: exists" in capsys.readouterr().err
    assert out.read_text() == "mine"
    assert fitted(run, out=out, options=["--force"]) == WRITTEN
    assert "rebound.restitution" in read_parameters(out)


def test_too_few_hits_are_refused_with_what_is_missing(tmp_path, capsys):
    out = tmp_path / "o.yaml"
    assert fitted(bumping_run(tmp_path, 4.0), out=out) == REFUSED
    (line,) = capsys.readouterr().err.splitlines()
    assert "restitution: " in line
    assert "expected at least 8" in line
    assert not out.exists()


def test_a_robot_that_never_hits_is_refused(tmp_path, capsys):
    assert fitted(bumping_run(tmp_path, 2.0, speeds=(0.0, 0.05)), out=tmp_path / "o.yaml") == REFUSED
    assert "0 impacts are faster" in capsys.readouterr().err


@pytest.mark.soak
@pytest.mark.parametrize(("believed", "off"), [(1.0, -0.04), (1.5, 0.0), (2.2, 0.06)])
def test_a_wrong_acceleration_moves_the_restitution(tmp_path, believed, off):
    """In truth 1.5 m/s^2: what the wheels take back before and after a hit is taken for the rebound."""
    found = []
    for i in range(8):
        folders = [bumping_run(tmp_path / "runs", 30.0, seed) for seed in (2 * i, 2 * i + 1)]
        for folder in folders:
            values = read_parameters(folder / "parameters.yaml") | {"robot.max_acceleration": believed}
            write_values(values, folder / "parameters.yaml")
        assert fitted(*folders, out=tmp_path / "o.yaml", options=["--force"]) == WRITTEN
        found.append(read_parameters(tmp_path / "o.yaml")["rebound.restitution"])
    assert sum(found) / len(found) == pytest.approx(0.7 + off, abs=0.015)


def rewritten(file, change):
    """trajectory.csv with its rows (dicts) changed in place."""
    rows = list(csv.DictReader(file.open()))
    change(rows)
    with file.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, rows[0])
        writer.writeheader()
        writer.writerows(rows)


def simulated_is(value):
    return lambda run: (run / "summary.json").write_text(json.dumps({"simulated": value}))


def in_row(line, **values):
    return lambda run: rewritten(run / "trajectory.csv", lambda rows: rows[line - 2].update(values))


def without_column(column):
    return lambda run: rewritten(run / "trajectory.csv", lambda rows: [row.pop(column) for row in rows])


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda run: shutil.rmtree(run), "run: not a folder"),
        (lambda run: (run / "trajectory.csv").unlink(), "trajectory.csv: cannot be read: No such file"),
        (lambda run: (run / "parameters.yaml").unlink(), "parameters.yaml: cannot be read"),
        (lambda run: (run / "summary.json").unlink(), "summary.json: cannot be read"),
        (lambda run: (run / "summary.json").write_text("{"), "summary.json: expected JSON"),
        (simulated_is("yes"), "summary.json: simulated: got 'yes', expected true or false"),
        (lambda run: (run / "trajectory.csv").write_bytes(b"\xff\xfe"), "trajectory.csv: cannot be read"),
        (lambda run: (run / "trajectory.csv").write_text(""), "trajectory.csv: no column t, x, y, yaw, cmd_vx, cmd_vy"),
        (without_column("cmd_vy"), "trajectory.csv: no column cmd_vy"),
        (in_row(9, x="somewhere"), "trajectory.csv, line 9, x: got 'somewhere', expected a finite number"),
        (in_row(9, y="nan"), "trajectory.csv, line 9, y: got 'nan'"),
        (in_row(9, cmd_vx="inf"), "trajectory.csv, line 9, cmd_vx: got 'inf'"),
        (in_row(9, cmd_vx=""), "trajectory.csv, line 9, cmd_vx: got ''"),
        (in_row(9, t="-3"), "trajectory.csv, line 9, t: got -3 after"),
        (lambda run: write_values({"lidar.world": "nowhere"}, run / "parameters.yaml"), "parameters.yaml: lidar.world"),
    ],
)
def test_a_folder_that_holds_no_run_is_named(run, tmp_path, capsys, spoil, said):
    spoil(run)
    assert fitted(run, out=tmp_path / "o.yaml") == REFUSED
    (line,) = capsys.readouterr().err.splitlines()
    assert str(run) in line
    assert said in line
    assert not (tmp_path / "o.yaml").exists()


def test_simulated_and_real_runs_do_not_mix(run, recorded, tmp_path, capsys):
    simulated_is(False)(run)
    assert fitted(run, recorded, out=tmp_path / "o.yaml") == REFUSED
    assert "expected one kind" in capsys.readouterr().err


def test_a_world_that_is_not_the_one_driven_in_is_noticed(run, tmp_path, capsys):
    write_values({**read_parameters(run / "parameters.yaml"), "lidar.world": "slalom"}, run / "parameters.yaml")
    assert fitted(run, out=tmp_path / "o.yaml") == REFUSED
    assert "no surface of the world at the robot's rim" in capsys.readouterr().out
