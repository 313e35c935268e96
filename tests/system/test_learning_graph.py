"""A robot of twice the mass through the graph, in one process: what it learns is used, recorded and told."""

import pytest

from collplan_core.parameters import Settings
from collplan_core.parameters.file import read_parameters, write_values
from collplan_core.warm_up import warm_up
from collplan_ros.bringup.main import run
from collplan_ros.bringup.options import parse
from collplan_ros.replay.main import main as replay


def test_a_load_is_learnt_told_and_replayed(tmp_path):
    warm_up()
    heavy, lab = tmp_path / "heavy.yaml", tmp_path / "lab.yaml"
    write_values({"simulator.mass_ratio": 2.0}, heavy)
    asked = ["--world", "serpentine:2", "--strategy", "bounce", "--no-pictures", "--params", str(heavy)]
    result = run(parse([*asked, "--out", str(tmp_path / "runs")]))
    assert result.summary["reached"], result.message
    drive = result.summary["drive"]
    assert drive["max_acceleration"] == pytest.approx(0.75, rel=0.06)
    assert drive["max_acceleration.low"] < drive["max_acceleration.learnt"] < drive["max_acceleration.high"]
    assert drive["in_words"].startswith("drives like 0.7")
    assert "set to 1.5; " in drive["in_words"]
    assert " with restitution 0." in drive["in_words"]
    lab.write_text("/**:\n  ros__parameters:\n" + "".join(f"    {line}\n" for line in drive["parameters"]))
    kept = Settings().with_values(read_parameters(lab))
    assert kept.robot.max_acceleration == pytest.approx(drive["max_acceleration"], rel=1e-3)
    assert replay([str(result.folder)]) == 0
