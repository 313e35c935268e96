"""The drive of a simulated robot, which parameters give as ratios to what is believed of it."""

from collplan_core.parameters import Settings


def same_simulated_drive(max_acceleration: float, lag: float, settings: Settings) -> dict[str, float]:
    """The ratios with which a simulated robot drives as under these settings, once other constants are believed.

    Args:
        max_acceleration: [m/s^2]; lag: [s]: the constants believed from then on.
    """
    robot, simulation = settings.robot, settings.simulator
    true_lag = robot.velocity_lag * simulation.mass_ratio
    acceleration = robot.max_acceleration * simulation.acceleration_ratio / simulation.mass_ratio
    mass_ratio = true_lag / lag if lag > 0.0 else simulation.mass_ratio
    return {
        "simulator.mass_ratio": round(mass_ratio, 4),
        "simulator.acceleration_ratio": round(acceleration * mass_ratio / max_acceleration, 4),
    }
