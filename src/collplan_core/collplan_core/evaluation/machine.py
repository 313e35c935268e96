"""Judges whether a machine is fast enough for a real robot: by the real-time factor and the longest gap of a run."""

from dataclasses import dataclass

ABOUT = 0.05
"""Share by which simulated time may run slower than it should and still count as on time."""


@dataclass(frozen=True)
class Timing:
    """The real-time factor and the longest gap of a graph.

    Attributes:
        factor: simulated seconds that passed in a second; None where it is not known, or the robot is not simulated.
        gap: longest time between two commands [s, wall clock].
    """

    factor: float | None = None
    gap: float = 0.0


def pace_words(factor: float | None) -> str:
    """Returns the real-time factor as "0.85x real time"; empty where it is unknown or about 1."""
    return "" if factor is None or abs(factor - 1.0) <= ABOUT else f"{factor:.2f}x real time"


def machine_verdict(timing: Timing, speed_factor: float, command_age: float) -> str:
    """Returns a sentence that the machine is too slow for a real robot; empty where all kept up.

    A simulation that is wanted slower than real time may be slow by as much, and one as fast as it can be is to be as
    fast as real time.

    Args:
        timing: timing of the graph.
        speed_factor: simulated seconds wanted in a second; 0 for as many as there can be.
        command_age: age at which a robot follows its last command no more [s].
    """
    wanted = min(speed_factor or 1.0, 1.0)
    is_slow = timing.factor is not None and timing.factor < (1.0 - ABOUT) * wanted
    if not is_slow and timing.gap <= command_age / wanted:
        return ""
    found = [f"simulated time ran at {timing.factor:.2f} of real time"] if is_slow else []
    if timing.gap:
        found.append(f"longest gap between two commands {timing.gap:.2f} s")
    return f"this machine is too slow for a real robot, or busy: {', '.join(found)}"
