"""The hash of the code that decides a trial's result."""

import shutil

import pytest

from collplan_study.run import code_state
from collplan_study.run.code_state import SIMULATOR, trial_code


@pytest.fixture
def simulator(tmp_path, monkeypatch):
    """A copy of the simulator's sources, which the hash is taken over."""
    copy = shutil.copytree(SIMULATOR, tmp_path / "omnipuck_sim", ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(code_state, "SIMULATOR", copy)
    return copy


def test_equal_sources_elsewhere_have_the_same_hash(simulator, monkeypatch):
    code = trial_code()
    monkeypatch.undo()
    assert code == trial_code()


@pytest.mark.parametrize("name", ["trial.py", "robot/physics.py", "robot/deeper/new.py"])
def test_a_change_of_the_simulator_changes_the_hash(simulator, name):
    before = trial_code()
    file = simulator / name
    file.parent.mkdir(exist_ok=True)
    with file.open("a", encoding="utf-8") as sources:
        sources.write("\nCHANGED = True\n")
    assert trial_code() != before


def test_a_file_moved_within_the_simulator_changes_the_hash(simulator):
    before = trial_code()
    (simulator / "robot" / "physics.py").rename(simulator / "physics.py")
    assert trial_code() != before
