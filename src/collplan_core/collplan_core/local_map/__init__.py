"""The sliding local map, from a scan alone. Paper: II-A."""

from collplan_core.local_map.build import build_local_map
from collplan_core.local_map.record import LocalMap

__all__ = ["LocalMap", "build_local_map"]
