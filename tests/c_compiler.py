"""Whether this machine can compile the reference firmware."""

import shutil

import pytest

from omnipuck_sim.emulator.c_library import COMPILER

NEEDS_COMPILER = pytest.mark.skipif(shutil.which(COMPILER) is None, reason="no C compiler")
