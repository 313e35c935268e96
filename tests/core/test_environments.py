"""A shell with ROS sourced and one without have an environment each; making one leaves the other alone."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from repository import ROOT

VENV = f"""\
import os, shutil, sys
from pathlib import Path
folder = Path(sys.argv[-1])
if "--clear" in sys.argv:
    shutil.rmtree(folder, ignore_errors=True)
(folder / "bin").mkdir(parents=True)
(folder / "bin" / "python").symlink_to({sys.executable!r})
(folder / "options").write_text(" ".join(sys.argv[1:-1]))
"""
"""Takes the place of the module venv."""
PIP = """\
import os, sys
with open(os.path.join(os.environ["VENV"], "installed"), "a") as file:
    print(*sys.argv, file=file)
"""
UNAME = "#!/bin/sh\necho Linux x86_64\n"


@pytest.fixture
def make(tmp_path):
    """`make` in a copy of the project's own set-up, where nothing is downloaded."""
    project, fakes = tmp_path / "project", tmp_path / "fakes"
    for path in ("Makefile", *(f"tools/{name}.sh" for name in ("setup", "find_python"))):
        (project / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / path, project / path)
    for name in ("constraints.txt", "constraints-oldest.txt"):
        (project / name).touch()
    for module, main in (("venv", VENV), ("pip", PIP), ("rclpy", "")):
        (fakes / module).mkdir(parents=True)
        (fakes / module / "__init__.py").touch()
        (fakes / module / "__main__.py").write_text(main)
    (fakes / "uname").write_text(UNAME)
    (fakes / "python3").symlink_to(sys.executable)
    (fakes / "uname").chmod(0o755)

    def run(target: str, **environment: str) -> Path:
        inherited = {key: value for key, value in os.environ.items() if key not in ("ROS_DISTRO", "MAKEFLAGS", "VENV")}
        path = {"PATH": f"{fakes}:{os.environ['PATH']}", "PYTHONPATH": str(fakes)}
        done = subprocess.run(
            ["make", "-C", str(project), target],
            env={**inherited, **path, **environment},
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return project

    return run


def test_each_kind_of_shell_keeps_its_environment(make):
    project = make(".venv/.ready")
    (project / ".venv" / "mine").touch()
    make(".venv-jazzy/.ready", ROS_DISTRO="jazzy")
    (project / ".venv-jazzy" / "mine").touch()
    make(".venv/.ready")
    make(".venv-jazzy/.ready", ROS_DISTRO="jazzy")
    for name, options in ((".venv", "--clear"), (".venv-jazzy", "--clear --system-site-packages")):
        assert (project / name / "mine").exists()
        assert (project / name / "options").read_text() == options
    ros = [("requirements-ros.txt" in (project / name / "installed").read_text()) for name in (".venv", ".venv-jazzy")]
    assert ros == [True, False]
