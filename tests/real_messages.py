"""The fixture `real_messages`: message packages that pip lacks, from a sourced ROS or from `make messages`."""

import ctypes
import importlib
import os
import sys
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

import pytest

INSTALLED = Path(__file__).parents[1] / ".messages" / "install"
MODULES = INSTALLED / "lib" / f"python{sys.version_info.major}.{sys.version_info.minor}" / "site-packages"
PACKAGES = {path.name for path in (Path(__file__).parent / "messages").iterdir()}


@pytest.fixture(scope="module")
def generated() -> Iterator[None]:
    """What `make messages` has made can be imported by a file's tests; those of other files run as with pip alone."""
    if "ROS_DISTRO" in os.environ:
        # libraries of two origins would have the same names
        yield
        return
    for library in sorted((INSTALLED / "lib").glob("lib*.so")):
        # type support opens its libraries by their names, and finds those of them that are open
        ctypes.CDLL(str(library))
    sys.path.append(str(MODULES))
    yield
    sys.path.remove(str(MODULES))
    for name in [name for name in sys.modules if name.split(".")[0] in PACKAGES]:
        del sys.modules[name]


@pytest.fixture
def real_messages(generated: None, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], ModuleType]:
    """A function that imports a module of a message package; the test is skipped where that is missing."""
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(INSTALLED), prepend=":")

    def imported(module: str) -> ModuleType:
        package = module.split(".")[0]
        if find_spec(package) is None:
            pytest.skip(f"{package} is missing: `make messages` makes it, where a compiler is")
        return importlib.import_module(module)

    return imported
