"""inspect finds the values of a simulated robot that was driven by hand, and tells how sure each is."""

import math
from types import SimpleNamespace as Message
from typing import Any

import numpy as np
import pytest
from driven_robots import ROOM

from collplan_core.impact import measured_impact
from collplan_core.parameters import Settings
from collplan_core.worlds.raycast import cast_beams
from collplan_ros.inspect.driving import find_driven, restitution_of
from collplan_ros.inspect.findings import find, wiring
from collplan_ros.inspect.found import Findings, Found
from collplan_ros.inspect.recording import Recording, Topics
from collplan_ros.inspect.stages import passed_through

STEP, LAG, BRAKES = 0.01, 0.15, 1.2
OFFSET, TILT, POST = (0.06, -0.04, 1.2), (0.05, -0.02), (20, 24)
BEAMS, TURN = 180, 0.1
ANGLES = -math.pi + math.tau / BEAMS * np.arange(BEAMS)
PROGRAMME = [
    *((0.0, 0.0, rate, 4.0) for rate in (0.9, -0.9, 1.1, -1.1)),
    *((x, y, 0.0, 1.2) for x, y in ((0.5, 0.0), (0.0, 0.5), (-0.5, 0.0), (0.0, -0.5)) for _ in range(3)),
]
"""Velocity commanded [m/s], yaw rate [rad/s] and time [s]; rest for 0.6 s after each."""


def stamp(at: float) -> Any:
    return Message(sec=int(at), nanosec=round(at % 1.0 * 1e9))


def commanded() -> np.ndarray:
    """(n, 3) velocity [m/s, robot frame] and yaw rate [rad/s], a step apart."""
    parts = [np.zeros((100, 3))]
    for *command, lasts in PROGRAMME:
        parts += [np.tile(command, (round(lasts / STEP), 1)), np.zeros((60, 3))]
    return np.concatenate(parts)


def driven_poses(commands: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """(n, 3) x, y [m] and yaw [rad] of a robot with lag and largest acceleration, and wheels that err."""
    poses, velocity, rate, error = [np.zeros(3)], np.zeros(2), 0.0, np.zeros(2)
    for k, (x, y, turn) in enumerate(commands):
        if k % 6 == 0:
            error = random.normal(0.0, 0.067, 2) * bool(x or y or turn)
        c, s = math.cos(poses[-1][2]), math.sin(poses[-1][2])
        ahead, left = np.array([x, y]) + error
        wanted = (np.array([c * ahead - s * left, s * ahead + c * left]) - velocity) / LAG
        velocity = velocity + STEP * wanted * min(1.0, BRAKES / max(float(np.hypot(*wanted)), 1e-9))
        rate += STEP / LAG * (turn - rate)
        poses.append(poses[-1] + STEP * np.array([*velocity, rate]))
    return np.array(poses[1:])


def pose_message(at: float, pose: np.ndarray, random: np.random.Generator) -> Any:
    """A body on the robot, in axes that are y up and tilted against the floor."""
    x, y, yaw = pose.tolist()
    c, s = math.cos(yaw), math.sin(yaw)
    x, y = np.array([x + c * OFFSET[0] - s * OFFSET[1], y + s * OFFSET[0] + c * OFFSET[1]]) + random.normal(0, 1e-3, 2)
    z, half = 0.1 + math.tan(TILT[0]) * x + math.tan(TILT[1]) * y, 0.5 * (yaw + OFFSET[2])
    turn = Message(x=0.0, y=math.sin(half), z=0.0, w=math.cos(half))
    return Message(
        header=Message(stamp=stamp(at), frame_id="room"),
        pose=Message(position=Message(x=x, y=z, z=-y), orientation=turn),
    )


def scan_message(at: float, pose: np.ndarray, random: np.random.Generator) -> Any:
    """A scan of a LIDAR at the robot's centre that gives 0 for one beam in eight, and sees a post of the robot."""
    ranges = cast_beams(ROOM, np.tile(pose[:2], (BEAMS, 1)), pose[2] + ANGLES) + random.normal(0.0, 0.008, BEAMS)
    ranges[random.random(BEAMS) < 0.12] = 0.0
    ranges[slice(*POST)] = 0.2 + random.normal(0.0, 0.003, POST[1] - POST[0])
    header, reach = Message(stamp=stamp(at), frame_id="laser"), {"range_min": 0.1, "range_max": 12.0}
    angles = {"angle_min": ANGLES[0], "angle_max": ANGLES[-1], "angle_increment": math.tau / BEAMS}
    return Message(header=header, **angles, **reach, time_increment=0.0, scan_time=0.0, ranges=ranges, intensities=[])


@pytest.fixture(scope="module")
def findings() -> Findings:
    random, commands = np.random.default_rng(4), commanded()
    poses, times = driven_poses(commands, random), 100.0 + STEP * np.arange(len(commands))
    rows = list(zip(times.tolist(), poses, commands, strict=True))
    recording = Recording(
        name="drive",
        topics=Topics("/body", "/scan", "/cmd_vel"),
        format="pose",
        duration=float(np.ptp(times)),
        poses=[(at + 0.002, pose_message(at, pose, random)) for at, pose, _ in rows[::2]],
        scans=[(at + 0.003, scan_message(at, pose, random)) for at, pose, _ in rows[:: round(TURN / STEP)]],
        commands=[
            (at, Message(linear=Message(x=x, y=y), angular=Message(z=turn))) for at, _, (x, y, turn) in rows[::5]
        ],
    )
    settings = Settings().with_values({key: each.value for key, each in wiring(recording, "").items()})
    found = find(recording, settings, lambda share: None)
    find_driven(found, recording, passed_through(recording, settings.with_values(found.values), lambda share: None))
    return found


def test_what_the_motion_shows_is_right_within_what_is_told(findings):
    truth = {
        **dict(zip((f"mocap.body_offset_{key}" for key in ("x", "y", "yaw")), OFFSET, strict=True)),
        "mocap.floor_tilt": TILT,
        "robot.max_acceleration": BRAKES,
        "robot.velocity_lag": LAG,
        "robot.motion_delay": 0.0,
        "scan.offset_x": 0.0,
        "scan.offset_y": 0.0,
        "scan.offset_yaw": 0.0,
        "scan.masked_angles": (ANGLES[POST[0] - 1], ANGLES[POST[1]]),
    }
    for key, value in truth.items():
        found = findings.found[key]
        assert np.abs(np.subtract(found.value, value)).max() < found.uncertainty, key
    assert findings.found["mocap.axes"] == Found("y_up")
    assert findings.found["scan.zero"] == Found("lost")
    assert "scan.infinite" in findings.missing
    assert findings.axes["mirrored"] is False
    assert {verdict for verdict, _ in findings.remarks} == {"ok"}


def test_restitution_needs_three_clear_impacts_that_agree():
    def impact(into: float, share: float, along: float = 0.0) -> Any:
        before = np.array([into, along])
        return measured_impact(0.0, np.zeros(2), before, np.array([-(1.0 + share) * into, 0.0]), 0.1, "poses")

    clear = [impact(0.5, share) for share in (0.62, 0.65, 0.68)]
    found = restitution_of([*clear, impact(0.1, 0.2), impact(0.5, 0.2, along=0.5), impact(0.5, -0.5)])
    assert found.value == pytest.approx(0.65)
    assert 0.1 < found.uncertainty < 0.2
    assert restitution_of(clear[:2]) is restitution_of([*clear, impact(0.5, 0.1)]) is None
