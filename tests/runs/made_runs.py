"""Logs of runs made by hand, and what a recorder would have written of them."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Path as PathMessage
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import String

from collplan_core.impact import POSES, SIMULATED, Impact
from collplan_core.parameters import Settings
from collplan_core.parameters.file import write_parameters
from collplan_core.plan import Contacts, timed_path
from collplan_core.worlds import World, save_world
from collplan_core.worlds.file import world_text
from collplan_core.worlds.raycast import simulate_scan
from collplan_ros.messages.conversions import scan_to_message, state_to_odometry
from collplan_ros.messages.planner_clouds import impact_to_cloud, plan_to_message
from collplan_ros.messages.raw_reading import plan_to_path
from collplan_ros.run.description import BEGIN, CLOCK, RUN, WORLD, YAML
from collplan_ros.run.description import GOAL as GOAL_GIVEN
from collplan_ros.run.run_log import PoseRow, RunLog, SentCommand, SentName
from collplan_ros.run.schemas import schema_text, type_name
from collplan_ros.run.writer import RECORDING, RecordingFile

Said = tuple[float, str, Any]
"""When a message was sent [s], its topic and the message."""
EPOCH = 1.7e9
AHEAD = EPOCH - 77.0
"""Of the poses' clock before the clock of sending [s]."""
THOUGHT = 0.03
"""From the stamp of a plan to when it is sent [s]."""
GOAL = np.array([0.0, 0.1])
WALL = 1.0
RADIUS = Settings().robot.radius
WINDOW = Settings().mocap.velocity_window
HIT_AT = 1.0
SPEED = 0.5
BACK = np.array([-1.0, 0.0])
HIT = Impact(EPOCH + HIT_AT - 0.003, np.array([WALL, 0.1]), BACK, -SPEED * BACK, 0.5 * SPEED * BACK)
"""The impact of the run that is made here."""


def room() -> World:
    block = np.array([[WALL, -1.0], [2.0, -1.0], [2.0, 1.0], [WALL, 1.0]])
    return World("room", (block,), np.array([[-1.0, 0.5, 0.2]]), (-2.0, -1.5, 2.5, 1.5))


def bouncing_run() -> RunLog:
    """Straight at a wall with SPEED, met at HIT_AT, and back with half of it."""
    log = RunLog(sent_maneuvers=[SentName(77.151, "free_space")])
    for k in range(200):
        t = 0.01 * k
        begin = WALL - RADIUS - SPEED * HIT_AT
        x = begin + SPEED * t if t < HIT_AT else WALL - RADIUS - 0.5 * SPEED * (t - HIT_AT)
        row = PoseRow(EPOCH + t, x, 0.1, 0.0, SPEED if t < HIT_AT else -0.5 * SPEED, 0.0, 77.0 + t)
        log.poses.append(row)
        log.truth.append(row)
        if k % 5 == 0:
            log.sent_commands.append(SentCommand(77.0 + t, 0.3 if t > 0.12 else 0.0, 0.0, 0.0))
        if k % 20 == 0:
            touched, after = np.array([[WALL, 0.12]]), np.array([[-0.6, 0.8]])
            touch = Contacts(np.array([EPOCH + HIT_AT + 0.02]), touched, after, BACK[None])
            log.plans[EPOCH + t] = touch if t < HIT_AT else Contacts.none()
            log.costs.append({"planning_time_ms": 1.0 + k, "candidates": 10.0, "candidates_before_pruning": 30.0})
    log.impacts.append(HIT)
    return log


def detected_only(log: RunLog) -> RunLog:
    """The run as a real robot leaves it, with its hit at HIT_AT detected in the poses."""
    return replace(log, truth=[], impacts=[replace(HIT, source=POSES)])


def write_recording(
    folder: Path,
    log: RunLog,
    said: Sequence[Said] = (),
    world: World | None = None,
    namespace: str = "",
    finished: bool = True,
) -> None:
    """Writes the run.mcap that bringup would have written of this run; the run itself has no end in it."""
    file = RecordingFile(folder / RECORDING)
    if world is not None:
        file.attach(WORLD, YAML, world_text(world))
    file.describe(RUN, {"simulated": "true", "namespace": namespace or "/", CLOCK: str(round(1e9 * AHEAD))})
    file.describe(BEGIN, {"simulated": "true"})
    file.describe(GOAL_GIVEN, {"sent": "0.0", "x": str(GOAL[0]), "y": str(GOAL[1])})
    for number, (sent, topic, message) in enumerate(sorted([*_said(log), *said], key=lambda row: row[0]), 1):
        kind = type_name(type(message))
        channel = file.channel(topic if topic.startswith("/") else f"{namespace}/{topic}", kind, schema_text(kind), {})
        at = round(1e9 * sent) + round(1e9 * AHEAD)
        file.write(channel, serialize_message(message), at, at, number)
    file.flush()
    left = (folder / RECORDING).read_bytes()
    file.finish()
    if not finished:
        (folder / RECORDING).write_bytes(left)


def killed_run(folder: Path) -> Path:
    """The folder of a run whose bringup was killed."""
    folder.mkdir(parents=True)
    save_world(room(), folder / "room.yaml")
    worlds = {key: str(folder / "room.yaml") for key in ("lidar.world", "simulator.world")}
    write_parameters(Settings().with_values(worlds), folder / "parameters.yaml")
    write_recording(folder, bouncing_run(), finished=False)
    return folder


def _said(log: RunLog) -> Iterator[Said]:
    frames = Settings().frames
    for topic, rows in (("mocap/odom", log.poses), ("ground_truth/odom", log.truth)):
        for row in rows:
            yield row.sent, topic, state_to_odometry(row.state, frames.map, frames.base)
    for row in log.sent_commands:
        turn = Vector3(x=0.0, y=0.0, z=row.wz)
        yield row.sent, "cmd_vel", Twist(linear=Vector3(x=row.vx, y=row.vy, z=0.0), angular=turn)
    for row in log.sent_maneuvers:
        yield row.sent, "maneuver", String(data=row.name)
    for hit in log.impacts:
        topic = "ground_truth/impact/contact" if hit.source == SIMULATED else "impact/contact"
        yield hit.time - AHEAD, topic, impact_to_cloud(hit, frames.map)
    for stamp, contacts in log.plans.items():
        x = next(row.x for row in log.poses if row.stamp >= stamp)
        path = np.array([[x, 0.1], [x + 0.5, 0.1]])
        plan = timed_path(stamp, stamp + np.array([0.0, 1.0]), path, np.zeros((2, 2)), contacts=contacts)
        trajectory = plan_to_message(plan, frames.map)
        yield plan.stamp - AHEAD + THOUGHT, "planner/trajectory", trajectory
        yield plan.stamp - AHEAD + THOUGHT, "plan", deserialize_message(plan_to_path(plan, frames.map), PathMessage)
    for row in log.poses[::5]:
        scan = simulate_scan(room(), row.state, Settings().lidar)
        yield scan.stamp - AHEAD, "scan", scan_to_message(scan, frames.base)
