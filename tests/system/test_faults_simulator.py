"""Each fault of `make faults` once: the simulated robot, the closed loop, and messages of nonsense."""

import pytest
from faults_once import wrong_of


@pytest.mark.timeout(900)
def test_each_fault_once(tmp_path):
    assert wrong_of(("simulator", "trial", "desk"), tmp_path) == []
