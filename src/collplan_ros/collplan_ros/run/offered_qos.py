"""QoS of a topic's publishers, as rosbag2 writes it into a channel."""

from collections.abc import Iterable
from typing import Any

import yaml

NANO = 10**9


def offered_qos(publishers: Iterable[Any]) -> str:
    """YAML with a profile a publisher.

    `publishers` are rclpy's infos of them. The DDS in use tells neither history nor depth of a publisher of another
    process: these are then `unknown` and 0, as in what rosbag2 records.
    """
    profiles = [_profile(publisher.qos_profile) for publisher in publishers]
    return yaml.safe_dump(profiles, sort_keys=False) if profiles else ""


def _profile(qos: Any) -> dict[str, Any]:
    return {
        "history": qos.history.name.lower(),
        "depth": qos.depth,
        "reliability": qos.reliability.name.lower(),
        "durability": qos.durability.name.lower(),
        "deadline": _duration(qos.deadline),
        "lifespan": _duration(qos.lifespan),
        "liveliness": qos.liveliness.name.lower(),
        "liveliness_lease_duration": _duration(qos.liveliness_lease_duration),
        "avoid_ros_namespace_conventions": qos.avoid_ros_namespace_conventions,
    }


def _duration(duration: Any) -> dict[str, int]:
    seconds, nanoseconds = divmod(duration.nanoseconds, NANO)
    return {"sec": seconds, "nsec": nanoseconds}
