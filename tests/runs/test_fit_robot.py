"""fit_robot on run folders of a simulated robot whose drive and rebounds are not those that the planner believes."""

import csv
import json
import shutil

import numpy as np
import pytest

from bumping_runs import bumping_run
from collplan_core.parameters import Settings
from collplan_core.parameters.file import read_parameters, write_values
from collplan_ros.runs import fit_rebound
from collplan_ros.runs.fit_robot import main
from collplan_ros.runs.impact_log import COLUMNS

WRITTEN, REFUSED = 0, 2


TRUTH = {
    "robot.max_acceleration": 2.0,
    "robot.velocity_lag": 0.13,
    "rebound.restitution": 0.55,
    "rebound.friction": 0.08,
}
MARGINS = dict(zip(TRUTH, (0.03, 0.02, 0.04, 0.05), strict=True))
"""Twice what the intervals are wide or less: a test with one seed."""
RATIOS = "simulator.mass_ratio", "simulator.acceleration_ratio"


def bumping(parent, duration, seed=0, believed=None, **values):
    """A run of a robot as TRUTH has it, which believed the shipped defaults."""
    true = {key.replace(".", "__").replace("rebound__", "simulator__"): value for key, value in TRUTH.items()}
    folder = bumping_run(parent, duration, seed, **{**true, **values})
    told = {"robot.max_acceleration": 1.5, "robot.velocity_lag": 0.1} | (believed or {})
    write_values(read_parameters(folder / "parameters.yaml") | told, folder / "parameters.yaml")
    return folder


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A run of a minute and a half."""
    return bumping(tmp_path_factory.mktemp("runs"), 90.0)


@pytest.fixture
def run(recorded, tmp_path):
    """A copy of it to spoil."""
    return shutil.copytree(recorded, tmp_path / "run")


def fitted(*folders, out, options=()):
    return main([*map(str, folders), "--out", str(out), *options])


def test_the_truth_is_found_not_the_belief(tmp_path, capsys):
    folders = [bumping(tmp_path / "runs", 50.0, seed) for seed in (0, 1)]
    out = tmp_path / "robot.yaml"
    assert fitted(*folders, out=out) == WRITTEN, capsys.readouterr().err
    found = read_parameters(out)
    assert found.keys() == {*TRUTH, *RATIOS}
    for key, truth in TRUTH.items():
        assert found[key] == pytest.approx(truth, abs=MARGINS[key]), key
    said = capsys.readouterr().out
    assert "2 simulated runs" in said
    assert str(out) in said
    assert "robot.max_acceleration: the runs believed 1.5, the poses say 2.0" in " ".join(said.split())
    comment = out.read_text().split("/**")[0]
    assert all(str(folder) in comment for folder in folders)
    assert "simulated" in comment
    assert "95 % interval" in comment
    assert "believed 1.5" in comment


def test_a_simulated_robot_that_believes_what_was_found_stays_the_one_that_was_driven(run, tmp_path):
    """Ratios and beliefs give the drive."""
    out, before = tmp_path / "o.yaml", Settings().with_values(read_parameters(run / "parameters.yaml"))
    assert fitted(run, out=out) == WRITTEN
    after = before.with_values(read_parameters(out))
    assert after.robot.max_acceleration != before.robot.max_acceleration
    for kept in (
        lambda s: s.robot.velocity_lag * s.simulator.mass_ratio,
        lambda s: s.robot.max_acceleration * s.simulator.acceleration_ratio / s.simulator.mass_ratio,
    ):
        assert kept(after) == pytest.approx(kept(before), rel=2e-3)


def test_what_was_believed_of_the_drive_does_not_count(run, recorded, tmp_path):
    values = read_parameters(run / "parameters.yaml")
    write_values({**values, "robot.max_acceleration": 3.0, "robot.velocity_lag": 0.2}, run / "parameters.yaml")
    assert fitted(run, out=tmp_path / "one.yaml") == WRITTEN
    assert fitted(recorded, out=tmp_path / "other.yaml") == WRITTEN
    one, other = read_parameters(tmp_path / "one.yaml"), read_parameters(tmp_path / "other.yaml")
    assert [one[key] for key in TRUTH] == pytest.approx([other[key] for key in TRUTH], abs=1e-6)


def test_by_its_earlier_name_it_says_the_new_one(run, tmp_path, capsys):
    assert fit_rebound.main([str(run), "--out", str(tmp_path / "o.yaml")]) == WRITTEN
    assert capsys.readouterr().err == "fit_rebound is fit_robot now, and will go with the next version\n"
    assert read_parameters(tmp_path / "o.yaml").keys() == {*TRUTH, *RATIOS}


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


def test_too_little_driving_is_refused_with_what_is_missing(tmp_path, capsys):
    out = tmp_path / "o.yaml"
    assert fitted(bumping(tmp_path, 4.0), out=out) == REFUSED
    (line,) = capsys.readouterr().err.splitlines()
    assert "s away from walls, expected at least 10 s" in line
    assert not out.exists()


def test_a_robot_that_creeps_along_walls_is_refused(tmp_path, capsys):
    assert fitted(bumping(tmp_path, 60.0, speeds=(0.0, 0.05)), out=tmp_path / "o.yaml") == REFUSED
    assert "away from walls, expected at least" in capsys.readouterr().err


def turned(degrees):
    """The commands as if recorded in a frame turned by this."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))

    def turn(rows):
        for row in rows:
            x, y = float(row["cmd_vx"]), float(row["cmd_vy"])
            row.update(cmd_vx=c * x - s * y, cmd_vy=s * x + c * y)

    return lambda run: rewritten(run / "trajectory.csv", turn)


def late(poses):
    """The commands as if recorded so many poses early."""

    def shift(rows):
        commands = [(row["cmd_vx"], row["cmd_vy"]) for row in rows]
        for row, (x, y) in zip(rows, commands[poses:] + commands[-1:] * poses, strict=True):
            row.update(cmd_vx=x, cmd_vy=y)

    return lambda run: rewritten(run / "trajectory.csv", shift)


@pytest.mark.parametrize("spoil", [turned(90.0), turned(25.0), late(20)])
def test_poses_that_no_drive_explains_are_refused(run, tmp_path, capsys, spoil):
    spoil(run)
    assert fitted(run, out=tmp_path / "o.yaml") == REFUSED
    said = capsys.readouterr().err
    assert "off the drive law" in said
    assert "expected at most" in said
    assert not (tmp_path / "o.yaml").exists()


def test_a_run_of_another_drive_is_named(recorded, tmp_path, capsys):
    other = bumping(tmp_path / "runs", 50.0, 7, robot__max_acceleration=1.2)
    assert fitted(recorded, other, out=tmp_path / "o.yaml") == REFUSED
    assert "drive" in capsys.readouterr().err
    assert not (tmp_path / "o.yaml").exists()


def test_another_radius_is_refused(run, recorded, tmp_path, capsys):
    write_values({"robot.radius": 0.08}, tmp_path / "lab.yaml")
    out = tmp_path / "o.yaml"
    assert fitted(recorded, out=out, options=["--params", str(tmp_path / "lab.yaml")]) == REFUSED
    assert "driven with 0.09 m, expected the 0.08 m" in capsys.readouterr().err
    write_values({**read_parameters(run / "parameters.yaml"), "robot.radius": 0.08}, run / "parameters.yaml")
    assert fitted(run, recorded, out=out) == REFUSED
    assert "expected runs of one robot" in capsys.readouterr().err
    assert not out.exists()


def test_wheels_that_pull_the_robot_back_are_told(tmp_path, capsys):
    wheels = {"simulator__wheel_mass": 0.35, "simulator__floor_friction": 0.5, "simulator__restitution": 0.85}
    heavy = [bumping(tmp_path / "runs", 90.0, seed, **wheels) for seed in (0, 1)]
    assert fitted(*heavy, out=tmp_path / "o.yaml") == WRITTEN, capsys.readouterr().err
    assert "their inertia counts" in capsys.readouterr().out


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


def without_rows(run):
    header, *_ = (run / "trajectory.csv").read_text().splitlines()
    (run / "trajectory.csv").write_text(header + "\n")


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
        (without_rows, "trajectory.csv: no poses, expected"),
        (without_column("cmd_vy"), "trajectory.csv: no column cmd_vy"),
        (in_row(9, x="somewhere"), "trajectory.csv, line 9, x: got 'somewhere', expected a finite number"),
        (in_row(9, y="nan"), "trajectory.csv, line 9, y: got 'nan'"),
        (in_row(9, cmd_vx="inf"), "trajectory.csv, line 9, cmd_vx: got 'inf'"),
        (in_row(9, cmd_vx=""), "trajectory.csv, line 9, cmd_vx: got ''"),
        (in_row(9, t="-3"), "trajectory.csv, line 9, t: got -3 after"),
        (
            lambda run: write_values({"simulator.world": "nowhere"}, run / "parameters.yaml"),
            "parameters.yaml: simulator.world",
        ),
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
    write_values({**read_parameters(run / "parameters.yaml"), "simulator.world": "slalom"}, run / "parameters.yaml")
    assert fitted(run, out=tmp_path / "o.yaml") == REFUSED
    assert not (tmp_path / "o.yaml").exists()
