"""Compiled code is made anew when a function it calls changes, in whatever file that one is."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import collplan_core.jit
from collplan_core.jit import private_folder, sources_digest

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


@pytest.mark.parametrize("mode", [0o700, 0o755, 0o775, 0o777])
def test_the_folder_of_the_cache_is_the_users_alone_and_holds_nothing_that_others_may_have_put_there(tmp_path, mode):
    folder = tmp_path / "cache"
    folder.mkdir()
    (folder / "planted.nbi").touch()
    folder.chmod(mode)
    assert private_folder(folder) == folder
    assert folder.stat().st_mode & 0o777 == 0o700
    assert (folder / "planted.nbi").exists() == (mode in (0o700, 0o755))


def test_a_folder_of_somebody_else_or_a_link_is_no_cache(tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(PermissionError, match="link: expected a folder of user"):
        private_folder(tmp_path / "link")
    monkeypatch.setattr(os, "getuid", lambda: 4711)
    with pytest.raises(PermissionError, match="elsewhere: expected a folder of user 4711"):
        private_folder(tmp_path / "elsewhere")


def test_where_the_home_cannot_be_used_the_cache_is_a_private_folder_elsewhere(tmp_path):
    (tmp_path / "home").write_text("no folder")
    (tmp_path / "tmp").mkdir()
    env = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "home"), "TMPDIR": str(tmp_path / "tmp")}
    code = "import collplan_core.jit, os; print(os.environ['NUMBA_CACHE_DIR'])"
    said = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True, timeout=60)
    folder = Path(said.stdout.strip())
    assert folder.is_relative_to(tmp_path / "tmp" / f"collplan-{os.getuid()}")
    assert {each.stat().st_mode & 0o777 for each in (folder, folder.parent)} == {0o700}
