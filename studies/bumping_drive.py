"""A simulated robot that is driven to and fro among walls, open loop: runs to fit its constants to."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from collplan_core.impact import Impact
from collplan_core.parameters import Settings
from collplan_core.plane import rotate
from collplan_core.sensing.pose_filter import PoseSample
from collplan_core.state import State
from collplan_core.worlds import World
from omnipuck_sim.robot.physics import Simulator

SPEEDS, STRETCH = (0.4, 1.1), 0.6
"""Slowest and fastest command [m/s], in any direction, for so long [s]."""
GRAZING, GRAZING_SPEEDS, GRAZING_STRETCH = (12.0, 22.0), (1.0, 1.2), 1.4
"""Every other command: to the far end, at this angle to the nearer long wall [deg]: the ring slides."""
YAW_GAIN = 2.0
"""[1/s]"""


class DrivenPose(NamedTuple):
    """One pose of a run.

    Attributes:
        measured: as the motion capture has it; truth: as it is.
        command: (2,) velocity commanded from this pose on [m/s, robot frame].
        turn: yaw rate commanded [rad/s].
        is_new: whether the command was sent at this pose.
        impacts: true ones since the last pose.
    """

    measured: PoseSample
    truth: State
    command: np.ndarray
    turn: float
    is_new: bool
    impacts: list[Impact]


def bumping_drive(
    world: World, settings: Settings, seed: int, duration: float, speeds: tuple[float, float] = SPEEDS
) -> Iterator[DrivenPose]:
    """The poses of a run of `duration` [s], whose commands are drawn from `seed`, in a room along x."""
    simulator = Simulator(world, settings, seed)
    random, rate = np.random.default_rng(seed), settings.simulator.physics_rate
    pose_steps, command_steps = round(rate / settings.simulator.mocap_rate), round(rate / settings.controller.rate)
    velocity, until, middle = np.zeros(2), 0, np.reshape(world.bounds, (2, 2)).mean(axis=0)
    for step in range(round(rate * duration)):
        if step >= until:
            velocity, length = _command(random, speeds, middle - simulator.state.position)
            until = step + command_steps * round(length * settings.controller.rate)
        is_new = step % command_steps == 0
        if is_new:
            # the heading is held, as the controller holds it
            yaw = simulator.state.yaw
            command, turn = np.array(rotate(*velocity.tolist(), -yaw)), float(np.clip(-YAW_GAIN * yaw, -1.0, 1.0))
            simulator.command(command, turn)
        if step % pose_steps == 0:
            yield DrivenPose(
                simulator.measured_pose(), simulator.state, command, turn, is_new, simulator.take_impacts()
            )
        simulator.step()


def _command(
    random: np.random.Generator, speeds: tuple[float, float], to_middle: np.ndarray
) -> tuple[np.ndarray, float]:
    """A velocity (2,) [m/s], and for how long [s]."""
    if random.random() < 0.5:
        angle = random.uniform(-np.pi, np.pi)
        return random.uniform(*speeds) * np.array([np.cos(angle), np.sin(angle)]), STRETCH
    graze = np.radians(random.uniform(*GRAZING))
    speed = random.uniform(*GRAZING_SPEEDS) * speeds[1] / SPEEDS[1]
    towards = np.where(to_middle * [1.0, -1.0] < 0.0, -1.0, 1.0)
    return speed * towards * [np.cos(graze), np.sin(graze)], GRAZING_STRETCH
