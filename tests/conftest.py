"""What every test runs in: its own ROS domain on this machine alone, with checked message fields."""

import fcntl
import importlib.util
import os
import signal
import tempfile
from pathlib import Path
from typing import Any, TextIO

import pytest
from hypothesis import is_hypothesis_test, settings

pytest_plugins = ["real_messages", "ros_fixture"]

# tests of nodes are named for it, so that core and simulator also run where no ROS is
collect_ignore_glob = (
    [] if importlib.util.find_spec("rclpy") else ["ros/*", "system/*", "foreign/*", "*/test_*node*.py"]
)


def free_domain() -> tuple[int, TextIO]:
    """A ROS domain that no other test process of this user has, and the lock that keeps it."""
    for domain in range(1, 100):
        lock = (Path(tempfile.gettempdir()) / f"collplan-{os.getuid()}-domain-{domain}.lock").open("w")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            lock.close()
            continue
        return domain, lock
    raise RuntimeError("no ROS domain is free")


DOMAIN, DOMAIN_LOCK = free_domain()
os.environ["ROS_DOMAIN_ID"] = str(DOMAIN)
if importlib.util.find_spec("rclpy"):
    from collplan_ros.node_kit.reachability import graph_environment

    # as bringup's nodes, whatever the user's own is
    os.environ.update(graph_environment("local", {}))
# read when the message modules are imported
os.environ["ROS_PYTHON_CHECK_FIELDS"] = "1"
if "ROS_DISTRO" not in os.environ:
    os.environ.pop("RMW_IMPLEMENTATION", None)


if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # ignored, as in the background of a shell, it would be ignored in every process started here; a handler is not
    signal.signal(signal.SIGINT, lambda *_: None)

# the same examples each time, on a machine of any pace
settings.register_profile("tests", derandomize=True, deadline=None, max_examples=30, print_blob=True)
settings.load_profile("tests")

GRAPHS = "tests/system/"
"""Where the tests of whole graphs are, most of them in processes and in real time."""
SOAK_TIMEOUT = 1200.0
"""A long test that says nothing else is taken for hanging after this [s]."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds --few-examples."""
    slow = os.environ.get("NUMBA_DISABLE_JIT", "0") != "0"
    words = "at most 10 examples of each property; so too where NUMBA_DISABLE_JIT=1 makes the loops slow"
    parser.addoption("--few-examples", action="store_true", default=slow, help=words)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Of processes side by side one gets all tests of whole graphs: one in real time wants most of two cores."""
    from xdist.scheduler import LoadFileScheduling

    class Scheduling(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return GRAPHS if nodeid.startswith(GRAPHS) else super()._split_scope(nodeid)

    return Scheduling(config, log)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Tests of graphs begin, long ones get their time, and few examples are taken where that was asked for."""
    items.sort(key=lambda item: not item.nodeid.startswith(GRAPHS))
    for item in items:
        if item.get_closest_marker("soak") and not item.get_closest_marker("timeout"):
            item.add_marker(pytest.mark.timeout(SOAK_TIMEOUT))
    if not config.getoption("few_examples"):
        return
    for item in items:
        test = getattr(item, "obj", None)
        if is_hypothesis_test(test):
            # no public name: examples given on a test itself come before those of a profile
            given = test._hypothesis_internal_use_settings  # noqa: SLF001
            few = settings(given, max_examples=min(given.max_examples, 10))
            test._hypothesis_internal_use_settings = few  # noqa: SLF001
