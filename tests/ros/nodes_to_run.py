"""Nodes that tests run as processes of their own: `python nodes_to_run.py KIND [ROS arguments]`."""

import os
import signal
import sys
import time

from rclpy.node import Node
from std_msgs.msg import String

from collplan_core.parameters import Robot
from collplan_ros.messages.qos import NEWEST
from collplan_ros.node_kit.node_parameters import declare
from collplan_ros.node_kit.run_node import publish_acknowledged, run_node


class Talking(Node):
    """Says one thing when ready and another at its end."""

    def __init__(self):
        super().__init__("talking")
        declare(self, Robot)
        self.publisher = self.create_publisher(String, "words", NEWEST)
        self.create_timer(0.05, lambda: self.publisher.publish(String(data="running")))
        print("ready", flush=True)

    def stop(self):
        acknowledged = publish_acknowledged(self.publisher, String(data="stopped"))
        print(f"acknowledged {acknowledged}", flush=True)


class Slow(Talking):
    """Is signalled before it is ready."""

    def __init__(self):
        os.kill(os.getpid(), getattr(signal, os.environ["SIGNAL"]))
        time.sleep(0.1)
        super().__init__()


class Failing(Talking):
    def __init__(self):
        super().__init__()
        self.create_timer(0.05, lambda: 1 / 0)


KINDS = {"talking": Talking, "slow": Slow, "failing": Failing}

if __name__ == "__main__":
    kind = sys.argv.pop(1)
    sys.exit(run_node(KINDS[kind]))
