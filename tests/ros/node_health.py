"""What a node reports of itself on /diagnostics, once a second."""

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED

NOTHING = DiagnosticStatus(level=DiagnosticStatus.STALE)


class NodeHealth:
    """The newest health of one node; make it before the node."""

    def __init__(self, ros, name: str) -> None:
        self._ros, self._name = ros, name
        self.reports = ros.listen(DiagnosticArray, "/diagnostics", DIAGNOSTICS_SUBSCRIBED)

    @property
    def newest(self) -> DiagnosticStatus:
        own = [status for report in self.reports for status in report.status if status.name == self._name]
        return own[-1] if own else NOTHING

    def value(self, key: str) -> str:
        return {each.key: each.value for each in self.newest.values}.get(key, "")

    def count(self, key: str) -> int:
        return int(self.value(key) or 0)

    def says(self, words: str, level: bytes | None = None) -> bool:
        """Waits for a report that holds these words, and has this level where one is given; whether it came."""
        return self._ros.wait_until(lambda: words in self.newest.message and level in (None, self.newest.level))

    def counts(self, key: str, least: int = 1) -> bool:
        return self._ros.wait_until(lambda: self.count(key) >= least)

    def refuses(self, **least: int) -> bool:
        return all(self.counts(f"refused_{kind}", n) for kind, n in least.items())
