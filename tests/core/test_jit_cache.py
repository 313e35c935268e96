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


def run_outer(package: Path, run: str = RUN, **variables: str | None) -> list[int]:
    env = {k: v for k, v in os.environ.items() if k not in ("NUMBA_CACHE_DIR", "NUMBA_DISABLE_JIT")}
    env |= {"PYTHONPATH": str(package.parent), "XDG_CACHE_HOME": str(package.parent / "cache")}
    env |= {key: value for key, value in variables.items() if value is not None}
    for key in (key for key, value in variables.items() if value is None):
        env.pop(key, None)
    command = [sys.executable, "-c", run]
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


def caches(package):
    return sorted(path for path in (package.parent / "cache").rglob("*.nb?") if path.name.startswith("outer"))


DAMAGES = {
    "half": lambda path: path.write_bytes(path.read_bytes()[: path.stat().st_size // 2]),
    "zeros at its end": lambda path: path.write_bytes(path.read_bytes()[:-400] + bytes(400)),
    "gone": lambda path: path.unlink(),
    "a folder": lambda path: (path.unlink(), path.mkdir()),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_cache_is_made_anew(package, damage):
    run_outer(package)
    files = caches(package)
    assert {path.suffix for path in files} == {".nbi", ".nbc"}
    for path in files:
        DAMAGES[damage](path)
        assert run_outer(package)[0] == 2, path
    if damage != "a folder":
        assert run_outer(package) == [2, 1]


NO_HOME = "import os, pwd; pwd.getpwuid = lambda uid: {}[uid]; "


@pytest.mark.parametrize(
    ("variables", "folder"),
    [
        ({"XDG_CACHE_HOME": None, "HOME": "home"}, "home/.cache/collplan"),
        ({"XDG_CACHE_HOME": "rel/ative", "HOME": "home"}, "home/.cache/collplan"),
        ({"XDG_CACHE_HOME": None, "HOME": None, "TMPDIR": "tmp"}, "tmp/collplan-"),
        ({"NUMBA_CACHE_DIR": "numba"}, "numba/collplan"),
        ({"NUMBA_CACHE_DIR": "/proc/none", "XDG_CACHE_HOME": "xdg"}, "xdg/collplan"),
    ],
)
def test_where_the_cache_is(package, variables, folder):
    absolute = {
        key: str(package.parent / value) if value in ("home", "xdg", "tmp", "numba") else value
        for key, value in variables.items()
    }
    (package.parent / "tmp").mkdir()
    # numba itself asks the account for its home
    code = RUN if variables.get("HOME", "home") else f"{NO_HOME}{RUN}"
    before = {path.name for path in package.parent.iterdir()}
    assert run_outer(package, code, **absolute) == [2, 0]
    found = [str(path.relative_to(package.parent)) for path in package.parent.rglob("outer*.nbi")]
    assert len(found) == 1, found
    assert found[0].startswith(folder)
    assert {path.name for path in package.parent.iterdir()} - before <= {folder.split("/")[0]}


def test_the_users_own_functions_go_on_in_the_users_own_folder(package):
    own = (
        "from collplan_core.jit import CACHE; import numba; print(2 if CACHE else 0, len(str(numba.config.CACHE_DIR)))"
    )
    assert run_outer(package, own) == [2, 0]
    assert run_outer(package, own, NUMBA_CACHE_DIR="/tmp") == [2, 4]
