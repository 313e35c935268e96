"""Manual override: whether a person drives the robot, why they must not, and the command that is then sent.

A person's command has priority over the planner's. It needs no plan, goal or scan, as the person sees the robot. The
robot's own report, the fence and a second person stop it. Without usable poses it is driven slowly.
"""

import math
from dataclasses import dataclass

import numpy as np

from collplan_core.command import HAND, Command, stopped
from collplan_core.control.follow import cut_to_limits, saturate
from collplan_core.control.permission import why_outside, why_stale
from collplan_core.parameters import Limits, Settings
from collplan_core.velocity_bounds import fastest_along, velocity_bounds

TAKEN = "driven by hand"
"""Reason why a robot is held after a person has driven it."""


@dataclass(frozen=True, eq=False)
class ManualCommand:
    """The newest command of a person."""

    velocity: np.ndarray  # (2,) [m/s, body frame]
    yaw_rate: float  # [rad/s]
    sent: float  # time at which the person's node sent it [s, local clock]
    trouble: str = ""  # reason not to follow it, such as several nodes that send such commands; empty without one
    released: bool = False  # whether the robot may go on after it: a person at rest has resumed

    @property
    def is_rest(self) -> bool:
        """True where it commands the robot to stand, as when the operator lets go."""
        return not self.velocity.any() and self.yaw_rate == 0.0


def overrides(hand: ManualCommand, local: float, limits: Limits) -> bool:
    """Returns whether a person drives at `local` [s, local clock]: the newest command is not older than hand_age."""
    return not why_stale("hand", local - hand.sent, limits.hand_age)


def why_no_override(
    hand: ManualCommand, robot_stands: str, lost: str, position: np.ndarray | None, limits: Limits
) -> str:
    """Returns why the robot must not be driven by hand now; "" where it may.

    Args:
        robot_stands, lost: why the robot itself stands, and why poses are unusable; "" where neither.
        position: (2,) newest position of the robot [m]; None before the first.
    """
    if robot_stands or hand.trouble:
        return robot_stands or hand.trouble
    if not limits.fence:
        return ""
    if lost or position is None:
        return f"not known to be within limits.fence: {lost or 'no pose yet'}"
    return why_outside(position, limits)


def overriding_command(hand: ManualCommand, before: Command, is_blind: bool, settings: Settings) -> Command:
    """Returns the command that is sent for a person's manual command; `before` is that of the last control period.

    It changes from `before` as fast as the wheels can follow, so that a person takes over without a jump. A command to
    stand takes effect at once. A command beyond the robot's limits is clamped to them, as the sender may know other
    limits. One that is not finite stops the robot. The speed is limited while `is_blind`: poses are lost, or the motion
    does not fit the commands.
    """
    robot, limits, period = settings.robot, settings.limits, 1.0 / settings.controller.rate
    if not (np.isfinite(hand.velocity).all() and math.isfinite(hand.yaw_rate)):
        x, y = hand.velocity.tolist()
        return stopped(f"by hand: got {x:g}, {y:g} m/s, {hand.yaw_rate:g} rad/s, expected finite numbers")
    wanted, turn = cut_to_limits(hand.velocity, hand.yaw_rate, robot)
    velocity, yaw_rate = np.zeros(2), 0.0
    if wanted.any():
        velocity = before.velocity + saturate(wanted - before.velocity, robot.max_acceleration * period)
        most = fastest_along(velocity_bounds(robot), velocity[0], velocity[1])
        velocity = saturate(velocity, min(most, limits.blind_speed) if is_blind else most)
    if turn:
        # the rim of a turning robot is as slow to follow
        most = robot.max_acceleration / robot.radius * period
        yaw_rate = before.yaw_rate + math.copysign(min(abs(turn - before.yaw_rate), most), turn - before.yaw_rate)
    return Command(velocity, yaw_rate, HAND, np.full(2, np.nan))
