"""Compiled code is made anew when a function it calls changes, in whatever file that one is."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import collplan_core.jit
from collplan_core.jit import private_folder

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


def test_the_folder_of_the_cache_is_the_users_alone_and_holds_nothing_that_others_may_have_put_there(tmp_path):
    for mode in (0o700, 0o755, 0o775, 0o777):
        folder = tmp_path / f"{mode:o}"
        folder.mkdir()
        (folder / "planted.nbi").touch()
        folder.chmod(mode)
        assert private_folder(folder) == folder
        assert folder.stat().st_mode & 0o777 == 0o700
        assert (folder / "planted.nbi").exists() == (mode in (0o700, 0o755))


def test_a_folder_of_somebody_else_or_a_link_is_no_cache(tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(PermissionError, match="link"):
        private_folder(tmp_path / "link")
    monkeypatch.setattr(os, "getuid", lambda: 4711)
    with pytest.raises(PermissionError, match="4711"):
        private_folder(tmp_path / "elsewhere")
