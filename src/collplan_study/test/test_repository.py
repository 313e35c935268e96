"""For `colcon test`: the tests of this package are in the repository around it."""

import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parents[3] / "tests"


@pytest.mark.skipif(not TESTS.is_dir(), reason="the repository around this package is not there")
@pytest.mark.timeout(0)
def test_this_package():
    assert subprocess.call([sys.executable, "-m", "pytest", TESTS / "study"], cwd=TESTS.parent) == 0
