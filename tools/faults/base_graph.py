"""bringup's graph behind a base without our firmware: the foreign robot of tests/foreign, in a hall."""

import os
import subprocess
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import yaml
from std_msgs.msg import String

import foreign_robot
from collplan_ros.bringup.network import environment_set
from collplan_ros.bringup.options import Options
from collplan_ros.messages.qos import EVENT
from faults.bench import BenchError
from faults.live_graph import LiveGraph
from faults.streams import Streams
from rooms import LIDAR_AT, Room

HALL = Room((16.0, 3.2), (2.0, 1.6), ((14.0, 1.6),), ())
COMMANDED, SWITCH = "/cmd_vel", "/fault"
"""Topics of the base: what base_node sends, and which fault it is to have."""
ROBOT = foreign_robot.PARAMETERS["robot"]


class BaseGraph(LiveGraph):
    """A bench: its robot is another process, which bringup knows by its topics alone."""

    ends = np.array(HALL.start), np.array(HALL.goals[0])
    fast, strategy = 0.7, "avoid"

    def _options(self, robot: str, folder: Path) -> Options:
        file = folder / "parameters.yaml"
        lidar = dict(zip(("offset_x", "offset_y", "offset_yaw"), LIDAR_AT, strict=True))
        given = {**foreign_robot.PARAMETERS, "scan": {"frame": "laser", **lidar}}
        file.write_text(yaml.safe_dump({"/**": {"ros__parameters": given}}), encoding="utf-8")
        asked = {"goal": HALL.goals[0], "scan": "real", "network": "local", "max_speed": ROBOT["max_speed"]}
        return Options(robot=robot, params=file, processes=True, **asked)

    def _streams(self) -> Streams:
        return Streams(self.listener.node, commands=COMMANDED, truth="/truth")

    def __enter__(self) -> "BaseGraph":
        if why := foreign_robot.missing():
            raise BenchError(f"the robot of tests/foreign cannot run: {why}")
        self._around = ExitStack()
        self._around.enter_context(environment_set(foreign_robot.environment()))
        self.base: subprocess.Popen[bytes] | None = None
        self.start_base()
        super().__enter__()
        self._faults = self.listener.node.create_publisher(String, SWITCH, EVENT)
        return self

    def __exit__(self, *exception: object) -> None:
        super().__exit__(*exception)
        self.end_base()
        self._around.close()

    def start_base(self) -> None:
        """Starts its process, where it does not run."""
        if self.base is None:
            self.base = foreign_robot.start(HALL, Path(self._temporary.name) / "room.yaml")

    def end_base(self) -> None:
        """Kills its process."""
        if self.base is not None:
            self.base.kill()
            self.base.wait()
            self.base = None

    def signal_base(self, number: int) -> float:
        """Sends its process a signal; returns when [s, steady clock]."""
        begun = self.now()
        if self.base is not None:
            os.kill(self.base.pid, number)
        return begun

    def tell_base(self, fault: str) -> float:
        """Switches its fault of this name on, "" for none; returns when [s, steady clock]."""
        begun = self.now()
        self._faults.publish(String(data=fault))
        return begun
