"""After an emergency stop a robot follows commands again only after a zero command, or after none for a while.

A commander that went on through the stop does not set the robot moving the moment the stop is cleared.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Arming:
    """Whether commands are followed.

    Attributes:
        quiet_since: the stop was cleared, or the last command ignored [s, any one clock]; None once armed.
    """

    quiet_since: float | None = None

    def is_waiting(self, now: float, silence: float) -> bool:
        """Whether commands are ignored at `now` [s]; they are not once none came for `silence` [s]."""
        return self.quiet_since is not None and now - self.quiet_since < silence

    def after_command(self, zero: bool, now: float, silence: float) -> "Arming":
        """The arming after a command, `zero` or not; the command may be followed where that `is_waiting` no longer."""
        return Arming(now) if self.is_waiting(now, silence) and not zero else ARMED


ARMED = Arming()
WAITING = "after the emergency stop: waiting for a zero command, or for none"
"""The robot's diagnostic message while it is waiting."""
