"""Motion planning for a robot that may bump into things: maps, planners, control and worlds, without ROS.

A world, a scan and a plan:

    from collplan_core import Settings, State, load_world, plan_once, simulate_scan
    world, settings = load_world("serpentine:2"), Settings().with_values({"planner.strategy": "bounce"})
    state = State.at_rest(world.start)
    plan, memory = plan_once(simulate_scan(world, state, settings.lidar), state, world.goal, settings)

`omnipuck_sim.run_trial` drives a simulated robot by it. docs/python.md has more, `__all__` what is kept stable.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collplan_core.local_map import LocalMap, build_local_map
    from collplan_core.parameters import ParameterError, Settings
    from collplan_core.plan import NoPlan, Plan, timed_path
    from collplan_core.planners import Planner, plan_once, register
    from collplan_core.scan import Scan
    from collplan_core.state import State
    from collplan_core.worlds import World, WorldError, load_world, world_segments
    from collplan_core.worlds.raycast import simulate_scan

__version__ = "1.2.0"
__all__ = [
    "LocalMap",
    "NoPlan",
    "ParameterError",
    "Plan",
    "Planner",
    "Scan",
    "Settings",
    "State",
    "World",
    "WorldError",
    "build_local_map",
    "load_world",
    "plan_once",
    "register",
    "simulate_scan",
    "timed_path",
    "world_segments",
]

_HOMES = {
    "local_map": ("LocalMap", "build_local_map"),
    "parameters": ("ParameterError", "Settings"),
    "plan": ("NoPlan", "Plan", "timed_path"),
    "planners": ("Planner", "plan_once", "register"),
    "scan": ("Scan",),
    "state": ("State",),
    "worlds": ("World", "WorldError", "load_world", "world_segments"),
    "worlds.raycast": ("simulate_scan",),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    """Imports what is asked for: all of it takes a second, which `--help` of a program need not wait for."""
    if name not in _HOME_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME_OF[name]}"), name)
