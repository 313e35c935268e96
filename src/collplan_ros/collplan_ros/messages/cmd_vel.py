"""The type of cmd_vel: Twist, or TwistStamped with controller.stamped_cmd_vel."""

from geometry_msgs.msg import Twist, TwistStamped

from collplan_core.command import Command
from collplan_core.parameters import Settings
from collplan_ros.messages.conversions import command_to_twist, header


def command_type(settings: Settings) -> type[Twist] | type[TwistStamped]:
    """The message type of cmd_vel."""
    return TwistStamped if settings.controller.stamped_cmd_vel else Twist


def command_to_message(command: Command, stamp: float, settings: Settings) -> Twist | TwistStamped:
    """A command as a message for cmd_vel; a TwistStamped carries the stamp [s, poses' clock]."""
    twist = command_to_twist(command)
    if settings.controller.stamped_cmd_vel:
        return TwistStamped(header=header(stamp, settings.frames.base), twist=twist)
    return twist
