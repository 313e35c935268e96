"""What a node says of itself."""

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED
from collplan_ros.node_kit.diagnostics import OK, WARN, Diagnostics, Health


def test_first_report_reaches_a_listener_that_comes_later(ros):
    node = ros.make(lambda **kwargs: Node("reporting", namespace="/robot1", **kwargs))
    reports = [Health(OK, "ready", {"count": 3, "ratio": 1 / 3, "world": "corridor"}), Health(WARN, "later")]
    Diagnostics(node, lambda: reports.pop(0) if len(reports) > 1 else reports[0])
    heard = ros.listen(DiagnosticArray, "/diagnostics", DIAGNOSTICS_SUBSCRIBED)
    assert ros.wait_until(lambda: heard)
    (status,) = heard[0].status
    assert (status.name, status.level, status.message) == ("/robot1/reporting", b"\x00", "ready")
    values = {value.key: value.value for value in status.values}
    assert values == {"count": "3", "ratio": "0.333333", "world": "corridor"}
    assert heard[0].header.stamp.sec > 0
    assert ros.wait_until(lambda: heard[-1].status[0].message == "later")
