"""Compiled code is made anew when a function it calls changes, in whatever file that one is."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import collplan_core.jit
from collplan_core.jit import sources_digest

INNER = """
from collplan_core.jit import njit

@njit
def inner(x):
    return x + {added}
"""
OUTER = """
from collplan_core.jit import njit
from collplan_core.inner import inner

@njit
def outer(x):
    return inner(x)
"""
RUN = "from collplan_core.outer import outer; print(outer(1), sum(outer.stats.cache_hits.values()))"


@pytest.fixture
def package(tmp_path):
    """A package of the core's name with the core's own jit.py and two compiled functions in two files."""
    package = tmp_path / "collplan_core"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "inner.py").write_text(INNER.format(added=1))
    (package / "outer.py").write_text(OUTER)
    shutil.copy(collplan_core.jit.__file__, package)
    return package


def run_outer(package: Path) -> list[int]:
    """The compiled answer of a fresh process, and how often it came from the cache."""
    env = {k: v for k, v in os.environ.items() if k not in ("NUMBA_CACHE_DIR", "NUMBA_DISABLE_JIT")}
    env |= {"PYTHONPATH": str(package.parent), "XDG_CACHE_HOME": str(package.parent / "cache")}
    command = [sys.executable, "-c", RUN]
    done = subprocess.run(command, env=env, cwd=package.parent, capture_output=True, text=True, check=True, timeout=60)
    return [int(word) for word in done.stdout.split()]


def test_change_in_a_called_file_is_noticed(package):
    assert run_outer(package) == [2, 0]
    assert run_outer(package) == [2, 1]
    (package / "inner.py").write_text(INNER.format(added=10))
    assert run_outer(package) == [11, 0]


@pytest.mark.parametrize(
    "change",
    [
        lambda package: (package / "inner.py").write_text(INNER.format(added=2)),
        lambda package: (package / "inner.py").rename(package / "renamed.py"),
        lambda package: (package / "outer.py").unlink(),
        lambda package: (package / "new.py").touch(),
        lambda package: ((package / "folder").mkdir(), (package / "outer.py").rename(package / "folder" / "outer.py")),
    ],
    ids=["edited", "renamed", "removed", "added", "moved"],
)
def test_digest_notices_every_change_of_the_sources(package, change):
    before = sources_digest(package)
    assert sources_digest(package) == before
    change(package)
    assert sources_digest(package) != before
