"""Each fault of `make faults` once: the robot behind a serial line, and runs that end while it drives.

A bringup that is killed and a full disk: test_run_ends.py.
"""

import pytest
from faults_once import wrong_of


@pytest.mark.timeout(900)
def test_each_fault_once(tmp_path):
    assert wrong_of(("serial", "bringup"), tmp_path) == []
