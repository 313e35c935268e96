"""What a graph lacks and what is in its way, in sentences for its user."""

from collections import Counter

from rclpy.node import Node

from collplan_core.parameters import Mocap
from collplan_ros.bringup.options import PLANNER
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.bringup.progress import in_words
from collplan_ros.node_kit.node_names import full_name
from collplan_ros.node_kit.publishers import known_publishers
from collplan_ros.run.recorder import Recorder

COMMANDS = "cmd_vel"
"""The topic of commands."""


def other_commanders(node: Node, commander: str) -> list[str]:
    """Full names of the nodes other than `commander`, in the namespace of `node`, that publish commands.

    A second node of the commander's own name is not detected here; bringup refuses it at its start.
    """
    return sorted(set(known_publishers(node, COMMANDS)) - {full_name(node.get_namespace(), commander)})


def seen_more_than(node: Node, expected: Counter[str]) -> list[str]:
    """Node names that occur more often than expected in the namespace of `node`; others do not count."""
    namespace = node.get_namespace()
    seen = Counter(name for name, space in node.get_node_names_and_namespaces() if space == namespace)
    return sorted(name for name, count in expected.items() if seen[name] > count)


INPUT_PATIENCE = 3.0
"""Longest wait for poses, scans and the answer to a goal, once every node is ready [s]."""
LONGEST_SILENCE = 2.5
"""Time without diagnostics after which a node counts as frozen [s]: each node sends them once a second."""


class Complaints:
    """Sentences about a graph, from its nodes' reports to a recorder."""

    def __init__(self, preparation: Preparation, recorder: Recorder, node: Node) -> None:
        """`node` resolves names."""
        self._preparation = preparation
        self._recorder = recorder
        self.name = node.resolve_topic_name
        """The full name of a topic or service."""

    @property
    def frozen(self) -> str:
        """Nodes that stopped reporting while their processes run, to append to a sentence; "" without any."""
        silent = self._recorder.silent(LONGEST_SILENCE)
        names = {name: self._preparation.full_name(name) for name in self._preparation.programs}
        found = [f"{name} for {silent[full]:.1f} s" for name, full in names.items() if full in silent]
        return f"; frozen: nothing on /diagnostics from {in_words(found)}" if found else ""

    @property
    def silent_nodes(self) -> list[str]:
        """Names of the nodes that have not reported yet."""
        reported = self._recorder.reported
        return [name for name in self._preparation.programs if self._preparation.full_name(name) not in reported]

    def unready(self, patience: float) -> str:
        """Nodes that have not reported for so long [s]."""
        silent = in_words(self.silent_nodes)
        return f"{silent} not ready within {patience:g} s: nothing on /diagnostics; {self._preparation.where}"

    def no_pose(self) -> str:
        """Complaint that no poses arrive."""
        mocap = self._preparation.settings.mocap
        source = f"{self.name(mocap.topic)} ({mocap.reliability.replace('_', ' ')})"
        said = self._recorder.status("mocap_node").message
        reason = f"; mocap_node: {said}" if said else ""
        if self._preparation.robot.simulated and mocap.topic != Mocap().topic:
            reason += f"; a simulated robot sends its poses on {self.name(Mocap().topic)}, not in a receiver's format"
        return f"{self.missing('mocap/odom', 'reliable')}, made from {source}{reason}"

    def no_scan(self) -> str:
        """Complaint that scans do not arrive, or cannot be used."""
        if self._recorder.scan_refused:
            return f"scans come on {self.name('scan')} and are refused: {self._recorder.scan_refused}"
        said = self._recorder.status(PLANNER).message
        return self.missing("scan", "best effort") + (f"; {PLANNER}: {said}" if said else "")

    def too_slow(self) -> str:
        """Complaint that poses arrive late."""
        return f"poses come {self._recorder.lateness:.1f} s late: this machine is too slow for the graph"

    def no_planner(self) -> str:
        """Complaint that a goal is not answered."""
        goal, status = self.name("goal_pose"), self.name("goal_status")
        said = f"no answer on {status} to the goal on {goal} (reliable) for {INPUT_PATIENCE:g} s"
        return f"{said}; {self._preparation.where}"

    def missing(self, topic: str, reliability: str) -> str:
        """Complaint that nothing arrives on a topic."""
        return f"nothing on {self.name(topic)} ({reliability}) for {INPUT_PATIENCE:g} s; {self._preparation.where}"

    def not_alone(self, who: str) -> str:
        """Complaint that nodes with names of this graph are in its domain."""
        return f"{who} in {self._preparation.where}; end it, or set another ROS_DOMAIN_ID"
