"""fit_robot on run folders of a simulated robot whose drive and rebounds are not those that the planner believes."""

import shutil

import pytest

from bumping_runs import bumping_run
from collplan_core.parameters import Settings
from collplan_core.parameters.file import read_parameters, write_values
from collplan_ros.fit.fit_robot import main
from collplan_ros.run.impacts import COLUMNS
from collplan_ros.run.writer import RECORDING

WRITTEN, REFUSED = 0, 2
TRUTH = {
    "robot.max_acceleration": 2.0,
    "robot.velocity_lag": 0.13,
    "rebound.restitution": 0.55,
    "rebound.friction": 0.08,
}
MARGINS = dict(zip(TRUTH, (0.03, 0.02, 0.04, 0.05), strict=True))
"""Twice what the intervals are wide or less: a test with one seed."""


def bumping(parent, duration, seed=0, **options):
    """A run of a robot as TRUTH has it, which believed the shipped defaults."""
    true = {key.replace(".", "__").replace("rebound__", "simulator__"): value for key, value in TRUTH.items()}
    folder = bumping_run(parent, duration, seed, **{**true, **options})
    changed(folder, **{"robot.max_acceleration": 1.5, "robot.velocity_lag": 0.1})
    return folder


def changed(folder, **values):
    """Writes these parameters into those of a run."""
    write_values(read_parameters(folder / "parameters.yaml") | values, folder / "parameters.yaml")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Two runs of most of a minute, without what a simulator tells of its impacts: it must not count."""
    runs = [bumping(tmp_path_factory.mktemp("runs"), 50.0, seed) for seed in (0, 1)]
    for run in runs:
        (run / "impacts.csv").write_text(",".join(COLUMNS) + "\n")
    return runs


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """A run that is too short to be fitted."""
    return bumping(tmp_path_factory.mktemp("runs"), 4.0)


@pytest.fixture
def spoiled(short, tmp_path):
    """A copy of it to spoil."""
    return shutil.copytree(short, tmp_path / "run")


def fitted(*folders, out, options=()):
    return main([*map(str, folders), "--out", str(out), *options])


def refused(capsys, *folders, out, options=()):
    """What is said of a fit that is not possible; nothing is written."""
    assert fitted(*folders, out=out, options=options) == REFUSED
    assert not out.exists()
    return capsys.readouterr().err


def test_the_truth_is_found_not_the_belief_and_the_simulated_robot_stays_the_same(recorded, tmp_path, capsys):
    """A run that is given twice counts once; the other values of a file are taken over."""
    out, lab = tmp_path / "robot.yaml", tmp_path / "lab.yaml"
    out.write_text("mine")
    write_values({"robot.mass": 0.9, "rebound.restitution": 0.1}, lab)
    (tmp_path / "latest").symlink_to(recorded[1])
    given = [*recorded, tmp_path / "latest"]
    assert fitted(*given, out=out, options=["--params", str(lab)]) == REFUSED
    assert f"--out {out}: exists" in capsys.readouterr().err
    assert out.read_text() == "mine"
    assert fitted(*given, out=out, options=["--params", str(lab), "--force"]) == WRITTEN, capsys.readouterr().err
    found = read_parameters(out)
    assert found.keys() == {*TRUTH, "simulator.mass_ratio", "simulator.acceleration_ratio", "robot.mass"}
    assert found["robot.mass"] == 0.9
    for key, truth in TRUTH.items():
        assert found[key] == pytest.approx(truth, abs=MARGINS[key]), key
    said, comment = capsys.readouterr().out, out.read_text().split("/**")[0]
    assert "2 simulated" in said
    assert "used 1.5" in " ".join(said.split())
    assert all(words in comment for words in (*map(str, recorded), "simulated", "95 %", "used 1.5"))
    before = Settings().with_values(read_parameters(recorded[0] / "parameters.yaml"))
    after = before.with_values(found)
    for kept in (
        lambda s: s.robot.velocity_lag * s.simulator.mass_ratio,
        lambda s: s.robot.max_acceleration * s.simulator.acceleration_ratio / s.simulator.mass_ratio,
    ):
        assert kept(after) == pytest.approx(kept(before), rel=2e-3)


def test_too_little_driving_is_refused_and_so_is_creeping_along_walls(short, tmp_path, capsys):
    for run in (short, bumping_run(tmp_path, 30.0, speeds=(0.0, 0.05))):
        assert "away from" in refused(capsys, run, out=tmp_path / "o.yaml")


def test_runs_of_two_radii_are_refused(short, spoiled, tmp_path, capsys):
    out = tmp_path / "o.yaml"
    write_values({"robot.radius": 0.08}, tmp_path / "lab.yaml")
    said = refused(capsys, short, out=out, options=["--params", str(tmp_path / "lab.yaml")])
    assert "0.08 m" in said
    changed(spoiled, **{"robot.radius": 0.08})
    assert "one robot" in refused(capsys, spoiled, short, out=out)


SPOILED = [
    (shutil.rmtree, "run: not a folder"),
    (lambda run: (run / RECORDING).unlink(), f"{RECORDING}: cannot be read"),
    (lambda run: (run / RECORDING).write_text("{"), f"{RECORDING}: expected a recording"),
    (lambda run: (run / "parameters.yaml").unlink(), "parameters.yaml"),
    (lambda run: changed(run, **{"simulator.world": "nowhere", "frames.map": "other"}), "no poses"),
]


def test_a_folder_that_holds_no_run_is_named(short, tmp_path, capsys):
    for number, (spoil, said) in enumerate(SPOILED):
        run = shutil.copytree(short, tmp_path / str(number) / "run")
        spoil(run)
        (line,) = refused(capsys, run, out=tmp_path / "o.yaml").splitlines()
        assert str(run) in line
        assert said in line
