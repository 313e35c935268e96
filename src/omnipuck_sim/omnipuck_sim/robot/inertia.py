"""Mass and moment of inertia of the simulated robot."""

from collplan_core.parameters import Robot, Simulation


def true_inertia(robot: Robot, simulation: Simulation) -> tuple[float, float]:
    """True mass [kg] and moment of inertia [kg m^2] of the body."""
    mass = simulation.mass_ratio * robot.mass
    share = robot.inertia_factor
    return mass, mass * robot.radius**2 * share / (1.0 - share)
