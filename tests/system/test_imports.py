"""Imports point one way, the algorithm knows no ROS, and each package declares what it imports."""

import ast
import re
import sys
import xml.etree.ElementTree as ElementTree
from importlib.metadata import requires
from pathlib import Path

import pytest

import collplan_core

SRC = Path(__file__).parents[2] / "src"
ORDER = ("collplan_core", "collplan_ros", "omnipuck_driver", "omnipuck_sim", "collplan_study", "collplan_gym")
OPTIONAL = {"nav2_msgs", "tf2_msgs"}
STANDARD_MESSAGES = {"geometry_msgs", "nav_msgs", "sensor_msgs", "std_msgs", "std_srvs", "visualization_msgs"}
SYSTEM_MESSAGES = {"action_msgs", "builtin_interfaces", "diagnostic_msgs", "rosgraph_msgs"}
ROS = {"rclpy", *OPTIONAL, "rcl_interfaces", *STANDARD_MESSAGES, *SYSTEM_MESSAGES}
WITH_ROS_IN_SIM = {
    *(f"omnipuck_sim.node.{name}" for name in ("simulated_mocap", "simulator_node")),
    "omnipuck_sim.emulator.firmware_emulator",
}
WITH_ROS_IN_RUNS = {"collplan_ros.run.recorder"}
WITH_ROS_IN_RUNS |= {f"collplan_ros.run.{name}" for name in ("graph_topics", "topics")} | {"collplan_ros.inspect.live"}
READING_RUNS = tuple(f"collplan_ros.{name}" for name in ("run", "replay", "view", "inspect"))
PLANNERS = ("paper_planner", "time_to_goal_planner")
ROSDEP_KEYS = {
    "cobs": "python-cobs-pip",
    "mcap": "mcap-ros2-support",
    "mcap_ros2": "mcap-ros2-support",
    "PIL": "python3-pil",
}
PIP_NAMES = {"mcap_ros2": "mcap_ros2_support", "mujoco": "mujoco_core", "serial": "pyserial"}
PIP_NAMES |= {"PIL": "pillow", "yaml": "PyYAML"}
WITHOUT_ROSDEP_KEY = {"distributed", "gymnasium", "mujoco", "polars", "pymunk", "rosbags"}


def module_name(path: Path) -> str:
    parts = path.relative_to(SRC).with_suffix("").parts[1:]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported(path: Path) -> set[str]:
    """Full names of what a file imports, wherever in the file it does; a name imported from a module counts with it."""
    names, tree = set(), ast.parse(path.read_text())
    # a package's own exports are imported when asked for
    tree.body = [
        node for node in tree.body if not (isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING")
    ]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return names


FILES = {module_name(path): path for package in ORDER for path in sorted((SRC / package / package).rglob("*.py"))}
IMPORTS = {module: imported(path) for module, path in FILES.items()}


def roots(module: str) -> set[str]:
    return {name.split(".")[0] for name in IMPORTS[module]}


def all_modules(module: str) -> set[str]:
    """The modules of the project that importing one of them imports in turn, itself among them."""
    seen, todo = set(), [module]
    while todo:
        at = todo.pop()
        parents = {at.rsplit(".", n)[0] for n in range(1, at.count(".") + 1)}
        new = ({name for name in IMPORTS[at] if name in FILES} | parents) - seen
        seen |= new
        todo += new
    return seen | {module}


def all_imports(module: str) -> set[str]:
    """What importing a module of the project imports in turn, first parts of the names."""
    return set().union(*(roots(m) for m in all_modules(module)))


def foreign_roots(package: str) -> set[str]:
    used = set().union(*(roots(module) for module in FILES if module.split(".")[0] == package))
    return used - set(sys.stdlib_module_names) - {package}


def test_imports_point_one_way_and_know_neither_ros_nor_physics_where_they_need_not():
    for module in FILES:
        package = module.split(".")[0]
        assert roots(module) & set(ORDER[ORDER.index(package) + 1 :]) == set(), module
        if package == "collplan_core":
            assert all_imports(module) & (ROS | {"pymunk", "matplotlib"}) == set(), module
        if module.startswith(READING_RUNS) and module not in WITH_ROS_IN_RUNS:
            assert all_imports(module) & ROS == set(), module
        if package in ("omnipuck_sim", "collplan_study", "collplan_gym") and module not in WITH_ROS_IN_SIM:
            assert all_imports(module) & (ROS | {"serial"}) == set(), module


@pytest.mark.parametrize("planner", PLANNERS)
def test_the_planners_do_not_know_each_other(planner):
    (other,) = set(PLANNERS) - {planner}
    modules = [m for m in FILES if m.startswith(f"collplan_core.{planner}")]
    assert len(modules) > 5
    for module in modules:
        assert not any(name.startswith(f"collplan_core.{other}") for name in all_modules(module)), module


@pytest.mark.parametrize("package", ORDER)
def test_each_package_declares_what_it_imports(package):
    folders = {path.parent for module, path in FILES.items() if module.split(".")[0] == package}
    assert [folder for folder in folders if not (folder / "__init__.py").exists()] == []
    manifest = ElementTree.parse(SRC / package / "package.xml")
    declared = {element.text for element in manifest.iter("exec_depend")}
    used = foreign_roots(package) - WITHOUT_ROSDEP_KEY - OPTIONAL
    keys = {name if name in ROS or name in ORDER else ROSDEP_KEYS.get(name, f"python3-{name}") for name in used}
    assert keys - declared == set()
    assert (SRC / package / "resource" / package).exists()
    needed = {line.split(";")[0].split(">")[0].strip().lower().replace("-", "_") for line in requires(package) or []}
    assert {PIP_NAMES.get(name, name).lower() for name in foreign_roots(package) - ROS} - needed == set()


def test_all_packages_have_one_version():
    files = [SRC / package / name for package in ORDER for name in ("package.xml", "setup.py")]
    files += [SRC / "collplan_core/collplan_core/__init__.py", SRC.parent / "CITATION.cff"]
    form = re.compile(r"""^(?: *<version>|    version="|__version__ = "|version: )([\w.]+)""", re.MULTILINE)
    for path in files:
        assert form.findall(path.read_text(encoding="utf-8")) == [collplan_core.__version__], path


def test_the_simulated_robot_knows_nothing_of_what_the_planners_believe():
    believed = {"collplan_core.reflection", "collplan_core.velocity_law"}
    for module in FILES:
        if module.startswith("omnipuck_sim.robot"):
            used = all_modules(module)
            assert used & believed == set(), module
            assert not [name for name in used if any(planner in name for planner in PLANNERS)], module
