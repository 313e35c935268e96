"""Simulated robots driven by hand, with sensors as drawn: what inspect writes of them is right, and no more."""

import math
from collections import Counter

import numpy as np
import pytest
from driven_robots import ROOM

from collplan_core.parameters import Settings
from collplan_core.worlds.spinning_lidar import sweeps_of
from collplan_ros.inspect.driving import find_driven
from collplan_ros.inspect.findings import find, wiring
from collplan_ros.inspect.found import Found
from collplan_ros.inspect.recording import Recording, Topics
from collplan_ros.inspect.stages import passed_through
from collplan_ros.messages.conversions import pose_to_message, scan_to_message, twist_of
from omnipuck_sim.robot.noise import added_latency, faulty
from omnipuck_sim.robot.physics import Simulator

ROBOTS, DURATION, STEPS, PERIOD = 40, 45.0, 4, 0.05
DRIVES = ("all", "all", "all", "all", "all", "all", "no turn", "rest")
POSES = {"mocap.rate", "mocap.floor_tilt", "mocap.axes"}
DRIVE = "max_acceleration", "velocity_lag", "motion_delay"
STRAIGHT = {"scan.offset_yaw", "scan.mirrored", "mocap.body_offset_yaw", *(f"robot.{key}" for key in DRIVE)}
MOUNT = ("offset_x", "offset_y", "offset_yaw", "stamp_offset", "mirrored")


def drawn(random: np.random.Generator) -> Settings:
    away, towards, yaw = random.uniform(0.0, 0.3), *random.uniform(-math.pi, math.pi, 2)
    place = (away * math.cos(towards), away * math.sin(towards), yaw, random.uniform(-0.5, 0.1), random.random() < 0.5)
    values = {f"lidar.{key}": value for key, value in zip(MOUNT, place, strict=True)}
    values |= {"lidar.sensor": "low_cost", "lidar.sweep": str(random.choice(["forwards", "backwards", "instant"]))}
    values |= {f"simulator.marker_offset_{axis}": random.uniform(-0.05, 0.05) for axis in "xy"}
    values |= {"simulator.floor_tilt": tuple(random.uniform(-0.05, 0.05, 2).tolist())}
    values |= {"simulator.mocap_fault": str(random.choice(["none", "bursts"]))}
    return Settings().with_values(values | {"simulator.mocap_rate": float(random.choice([20.0, 50.0, 100.0]))})


def recorded(settings: Settings, seed: int, drive: str) -> Recording:
    """Of turns in place and ways between random points; "no turn" keeps the heading, and "rest" stands."""
    simulator, sweeps = Simulator(ROOM, settings, seed, np.zeros(2)), sweeps_of(ROOM, settings.lidar, seed)
    taken = Recording("drawn", Topics("/pose", "/scan", "/cmd_vel"), "pose", DURATION)
    random, aim, fault, last = np.random.default_rng(seed), np.zeros(2), settings.simulator.mocap_fault, None
    rate = settings.simulator.physics_rate / STEPS
    for count in range(round(DURATION * rate)):
        now, state = simulator.time, simulator.state
        if count % round(PERIOD * rate) == 0:
            aim = random.uniform((-1.3, -0.9), (1.3, 0.9)) if np.hypot(*(aim - state.position)) < 0.1 else aim
            spin = (0.0 if now < 1.0 else 1.0 if now < 8.0 else -1.0) if now < 15.0 else math.sin(0.4 * now)
            c, s = math.cos(state.yaw), math.sin(state.yaw)
            way = np.array([[c, s], [-s, c]]) @ (aim - state.position) * (now > 15.0 or drive == "no turn")
            asked = way * min(1.5, 0.6 / max(float(np.hypot(*way)), 1e-9)) * (drive != "rest")
            simulator.command(asked, spin * (drive == "all"))
            taken.commands.append((now, twist_of(asked, spin * (drive == "all"))))
        if count % round(rate / settings.simulator.mocap_rate) == 0:
            last = faulty(simulator.measured_pose(), fault, last)
            taken.poses.append((now + added_latency(fault, now), pose_to_message(last, "map")))
        scan = sweeps.take_pose(state)
        if scan is not None and scan.stamp > 0.0:
            taken.scans.append((now, scan_to_message(scan, "laser")))
        simulator.step(STEPS)
    return taken


def truth_of(settings: Settings) -> dict[str, object]:
    lidar, simulation = settings.lidar, settings.simulator
    swept = {"scan.backwards": lidar.sweep == "backwards", "scan.instant": lidar.sweep == "instant"}
    robot = {f"robot.{key}": getattr(settings.robot, key) for key in DRIVE}
    body = {f"mocap.body_offset_{axis}": getattr(simulation, f"marker_offset_{axis}") for axis in ("x", "y", "yaw")}
    body |= {"mocap.rate": simulation.mocap_rate, "mocap.floor_tilt": simulation.floor_tilt, "mocap.axes": "z_up"}
    return {f"scan.{key}": getattr(lidar, key) for key in MOUNT} | swept | body | robot


def is_right(key: str, found: Found, true: object) -> bool:
    if found.uncertainty is None:
        return found.value == true
    error = np.subtract(found.value, true)
    wrapped = math.remainder(error, math.tau) if key.endswith("yaw") else error
    return bool((np.abs(wrapped) <= found.uncertainty).all())


@pytest.mark.soak
def test_what_is_written_is_right_within_its_uncertainty_and_nothing_that_was_not_shown():
    written, right, drives = Counter[str](), Counter[str](), Counter[str]()
    for seed in range(ROBOTS):
        settings, drive = drawn(np.random.default_rng(seed)), DRIVES[seed % len(DRIVES)]
        recording = recorded(settings, seed, drive)
        told = {key: each.value for key, each in wiring(recording, "").items()}
        given, truth = Settings().with_values(told), truth_of(settings)
        findings = find(recording, given, lambda share: None)
        stages = passed_through(recording, given.with_values(findings.values), lambda share: None)
        find_driven(findings, recording, stages)
        judged = {key: is_right(key, each, truth[key]) for key, each in findings.found.items() if key in truth}
        written.update(judged), right.update(key for key, good in judged.items() if good), drives.update([drive])
        for key, each in findings.found.items():
            if not judged.get(key, True):
                print(seed, drive, key, each, truth[key], settings.lidar.sweep, settings.simulator.mocap_fault)
        shown = {"all": set(judged), "no turn": POSES | STRAIGHT, "rest": POSES}[drive]
        assert set(judged) <= shown, (seed, drive)
    print(
        "| value | written of 40 | right |",
        *(f"| {key} | {n} | {right[key]} |" for key, n in written.items()),
        sep="\n",
    )
    assert right.total() >= 0.95 * written.total()
    assert written["scan.offset_x"] >= 0.8 * drives["all"]
