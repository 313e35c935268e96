"""Faults of a motion capture, on request: parameter simulator.mocap_fault."""

from collections.abc import Callable
from dataclasses import replace
from math import pi, radians, remainder, tau

from collplan_core.sensing.pose_filter import PoseSample

LATE = "late"
MORE_LATENCY = 0.2
"""Additional delay of poses with fault `late` [s]."""
HOUR = 3600.0
"""Error of the stamps of poses with faults `hour_ahead` and `hour_back` [s]."""


def _turned(angle: float) -> Callable[[PoseSample], PoseSample]:
    return lambda sample: replace(sample, yaw=remainder(sample.yaw + angle, tau))


_FAULTS: dict[str, Callable[[PoseSample], PoseSample]] = {
    "yaw_90": _turned(pi / 2),
    "yaw_180": _turned(pi),
    "tilt": lambda sample: replace(sample, tilt=radians(30.0)),
    "lift": lambda sample: replace(sample, height=sample.height + 0.2),
    "hour_ahead": lambda sample: replace(sample, stamp=sample.stamp + HOUR),
    "hour_back": lambda sample: replace(sample, stamp=sample.stamp - HOUR),
}


def faulty(sample: PoseSample, fault: str) -> PoseSample:
    """The measured pose with this fault, a value of simulator.mocap_fault."""
    return _FAULTS[fault](sample) if fault in _FAULTS else sample


def added_latency(fault: str) -> float:
    """Returns how much later poses come with this fault [s]."""
    return MORE_LATENCY if fault == LATE else 0.0
