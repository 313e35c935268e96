"""The manual override: whether a person drives the robot, why they must not, and what of their command is sent.

A person's command goes before the planner's, and needs no plan, goal or scan: a person sees the robot. What the robot
reports of itself, the fence and a second person stop it. Without usable poses, it is driven slowly.
"""

import math
from dataclasses import dataclass

import numpy as np

from collplan_core.command import HAND, Command, stopped
from collplan_core.control.permission import why_outside, why_stale
from collplan_core.control.tracking import cut_to_limits, saturate
from collplan_core.parameters import Limits, Settings

TAKEN = "driven by hand"
"""Why a robot that a person has driven is held."""


@dataclass(frozen=True, eq=False)
class ManualCommand:
    """The newest command of a person.

    Attributes:
        velocity: (2,) [m/s, body frame].
        yaw_rate: [rad/s].
        sent: when it left the person's end [s, local clock].
        trouble: why it must not be followed, as where several nodes send such commands; empty where it may.
    """

    velocity: np.ndarray
    yaw_rate: float
    sent: float
    trouble: str = ""

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
    """Returns the reason why the robot must not be driven by hand now; "" where it may.

    Args:
        robot_stands: why the robot itself stands; empty where it does not.
        lost: why poses are not to be used now; empty where they are.
        position: (2,) newest of the robot [m]; None before the first.
    """
    if robot_stands or hand.trouble:
        return robot_stands or hand.trouble
    if not limits.fence:
        return ""
    if lost or position is None:
        return f"not known to be within limits.fence: {lost or 'no pose yet'}"
    return why_outside(position, limits)


def overriding_command(hand: ManualCommand, before: Command, is_blind: bool, settings: Settings) -> Command:
    """Returns the command that is sent for a person's manual command.

    It goes from the command before as fast as wheels can follow, so that a person takes over without a jump.
    What is commanded to rest rests at once. What is beyond the robot's limits is cut to them: who pushes a stick
    farther does not mean to stand, and the sender may know other limits. A command that is not finite is one to stand.

    Args:
        before: the command sent a control period earlier.
        is_blind: whether the controller cannot vouch for the motion.
    """
    robot, limits, period = settings.robot, settings.limits, 1.0 / settings.controller.rate
    if not (np.isfinite(hand.velocity).all() and math.isfinite(hand.yaw_rate)):
        x, y = hand.velocity.tolist()
        return stopped(f"by hand: got {x:g}, {y:g} m/s, {hand.yaw_rate:g} rad/s, expected finite numbers")
    wanted, turn = cut_to_limits(hand.velocity, hand.yaw_rate, robot)
    velocity, yaw_rate = np.zeros(2), 0.0
    if wanted.any():
        velocity = before.velocity + saturate(wanted - before.velocity, robot.max_acceleration * period)
        velocity = saturate(velocity, min(robot.max_speed, limits.blind_speed) if is_blind else robot.max_speed)
    if turn:
        # the rim of a turning robot is as slow to follow
        most = robot.max_acceleration / robot.radius * period
        yaw_rate = before.yaw_rate + math.copysign(min(abs(turn - before.yaw_rate), most), turn - before.yaw_rate)
    return Command(velocity, yaw_rate, HAND, np.full(2, np.nan))
