"""Title of a picture of a run."""

from collections.abc import Mapping
from typing import Any

from collplan_core.parameters import Settings
from collplan_core.worlds import World
from collplan_ros.run.result_files import counted_impacts

LONGEST = 120
"""Characters of a world's name that are shown."""


def run_title(world: World, settings: Settings, simulated: bool) -> str:
    """World, strategy and seed of a run, and whether it was simulated, on one line."""
    # a world's name may be any text: both ends of it tell more than its beginning
    name = " ".join(world.name.split())
    if len(name) > LONGEST:
        name = f"{name[: LONGEST // 2]}...{name[3 - LONGEST // 2 :]}"
    kind = "simulated" if simulated else "measured"
    return f"{name}, {settings.planner.strategy}, seed {settings.simulator.seed} ({kind})"


def run_end(summary: Mapping[str, Any]) -> str:
    """Returns the end of a run on one line; `summary` is the content of summary.json."""
    arrival = summary["arrival_time_s"]
    end = f"goal reached in {arrival:.1f} s" if arrival is not None else summary["outcome"].replace("_", " ")
    return f"{end}, {summary['path_length_m']:.2f} m, {counted_impacts(summary['impacts'])}"
