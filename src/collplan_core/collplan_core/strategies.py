"""The strategies by name: the paper's are weight sets (IV-B), the time-to-goal ones set effect and cost of contacts.

The parameters take the choices of `planner.strategy` from here, so that nothing of theirs is imported.
"""

from dataclasses import dataclass

PAPER_WEIGHTS: dict[str, dict[str, float]] = {
    "harness": {"position": 100.0, "risk": 0.1, "velocity": 4.0},
    "high_risk": {"position": 100.0, "risk": 0.1, "velocity": 0.0},
    "low_risk": {"position": 100.0, "risk": 100.0, "velocity": 0.0},
}

REFLECTS, STOPS = "reflects", "stops"
"""Effect of a boundary on the normal speed of a contact."""
FREE, BY_SPEED, AVERSE = "free", "by_speed", "averse"
"""Cost of a contact."""


@dataclass(frozen=True)
class ContactTerms:
    """Properties that tell one time-to-goal strategy from another."""

    contact_law: str  # REFLECTS or STOPS
    contact_tolerance: str  # FREE, BY_SPEED or AVERSE
    stop_test: bool = False  # whether the robot must be able to brake within what it has seen


TIME_TO_GOAL: dict[str, ContactTerms] = {
    "bounce": ContactTerms(REFLECTS, BY_SPEED),
    "tolerate": ContactTerms(STOPS, FREE),
    "avoid": ContactTerms(STOPS, AVERSE),
    "stop_guarantee": ContactTerms(STOPS, AVERSE, stop_test=True),
}

NAMES = [*PAPER_WEIGHTS, "custom", *TIME_TO_GOAL]
"""The choices of `planner.strategy`; `planners.py: register` adds to them."""


def is_careful(strategy: str) -> bool:
    """Whether a strategy of this name enters what no scan has had in view only as fast as a touch may be."""
    return strategy in TIME_TO_GOAL and TIME_TO_GOAL[strategy].contact_tolerance == AVERSE
