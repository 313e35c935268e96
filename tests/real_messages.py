"""The fixture `real_messages`: message packages that pip lacks, installed or made by `make messages`."""

import ctypes
import importlib
import sys
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

import pytest

INSTALLED = Path(__file__).parents[1] / ".messages" / "install"
MODULES = INSTALLED / "lib" / f"python{sys.version_info.major}.{sys.version_info.minor}" / "site-packages"


@pytest.fixture(scope="module")
def generated() -> Iterator[set[str]]:
    """What `make messages` has made can be imported in this file's tests, and no longer after them.

    The others run as where pip alone was used. The set gets the names of the packages imported.
    """
    for library in sorted((INSTALLED / "lib").glob("lib*.so")):
        # type support opens its libraries by their names, and finds those of them that are open
        ctypes.CDLL(str(library))
    sys.path.append(str(MODULES))
    packages: set[str] = set()
    yield packages
    sys.path.remove(str(MODULES))
    for name in [name for name in sys.modules if name.split(".")[0] in packages]:
        del sys.modules[name]


@pytest.fixture
def real_messages(generated: set[str], monkeypatch: pytest.MonkeyPatch) -> Callable[[str], ModuleType]:
    """A function that imports a module of a message package; the test is skipped where there is none."""
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(INSTALLED), prepend=":")

    def imported(module: str) -> ModuleType:
        package = module.split(".")[0]
        if find_spec(package) is None:
            pytest.skip(f"{package} is neither installed nor made by `make messages`")
        if str(MODULES) in str(find_spec(package).origin):
            generated.add(package)
        return importlib.import_module(module)

    return imported
