"""Subscription callbacks that also take DDS's information on a message: its send time and its number."""

from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any

Info = Mapping[str, Any]
"""source_timestamp [ns, wall clock of the sender], publication_sequence_number and more, by name."""
Take = Callable[[Any, Info], None]
"""Takes a message and DDS's information on it."""


def with_info(take: Take) -> Take:
    """The callback to subscribe with, under whichever executor."""

    # rclpy counts the parameters, which `wraps` shows. EventsExecutor (rclpy 7.1.6) gives the two as one tuple
    @wraps(take)
    def taking(*given: Any) -> None:
        message, info = given[0] if len(given) == 1 else given
        take(message, info)

    return taking
