"""What an older library may lack: everything imports, each planner drives a trial, and files are read as written."""

import importlib
import pkgutil

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_core.worlds import load_world, save_world
from collplan_ros.run.reader import attachment, description
from collplan_ros.run.writer import RecordingFile
from omnipuck_sim.trial import run_trial

PACKAGES = ("collplan_core", "collplan_ros", "omnipuck_driver", "omnipuck_sim", "collplan_study", "collplan_gym")
NOT_THERE = ("rclpy", "casadi", "_msgs", "_interfaces", "std_srvs")
"""ROS and what nobody installs with the packages, by the ends of their names."""


def test_every_module_imports():
    missing = set()
    for package in map(importlib.import_module, PACKAGES):
        for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            try:
                importlib.import_module(found.name)
            except ModuleNotFoundError as error:
                missing.add(error.name.split(".")[0])
    assert all(name.endswith(NOT_THERE) for name in missing), missing


@pytest.mark.parametrize(("strategy", "engine"), [("harness", "pymunk"), ("bounce", "pymunk"), ("bounce", "mujoco")])
def test_a_trial_of_each_planner(strategy, engine):
    pytest.importorskip("mujoco" if engine == "mujoco" else "pymunk")
    values = {"planner.strategy": strategy, "simulator.engine": engine, "trial.timeout": 15.0}
    assert run_trial(load_world("corridor"), Settings().with_values(values), 3).outcome == "reached"


def test_files_are_read_as_written(tmp_path):
    world = load_world("slalom")
    save_world(world, tmp_path / "world.yaml")
    again = load_world(str(tmp_path / "world.yaml"))
    np.testing.assert_array_equal(again.start, world.start)
    recording = RecordingFile(tmp_path / "run.mcap")
    recording.describe("run", {"goal": "1.0 2.0"})
    recording.attach("world.yaml", "application/yaml", (tmp_path / "world.yaml").read_text())
    recording.finish()
    assert description(tmp_path / "run.mcap", "run") == {"goal": "1.0 2.0"}
    assert attachment(tmp_path / "run.mcap", "world.yaml") == (tmp_path / "world.yaml").read_text()
