"""Whether a robot goes on driving although it was told to stand."""

from collplan_core.parameters import Robot

LAGS = 3.0
"""Time constants of the velocity loop after which what is left of a velocity is small."""
MOVES = 0.1
"""Speed from which on a robot moves: noise of poses and drive moves one at rest by less [m/s]."""


def why_runaway(speed: float, speed_then: float, stopped_for: float, patience: float, robot: Robot) -> str:
    """Returns in words that a robot does not obey zero; "" where it stands, or may still be braking.

    Args:
        speed, speed_then: speed now, and when zero was first sent [m/s].
        stopped_for: time since then [s].
        patience: time allowed beyond the way to brake: delays of the command and of the pose [s].
    """
    braking = speed_then / robot.max_acceleration + LAGS * robot.velocity_lag
    if speed <= MOVES or stopped_for <= braking + patience:
        return ""
    return f"drives on at {speed:.2f} m/s, {stopped_for:.1f} s after zero"
