"""Small worlds, flights and hits that the physics tests share."""

from dataclasses import replace

import numpy as np

from collplan_core.parameters import Settings, Simulation
from collplan_core.worlds import World
from omnipuck_sim.robot.drive import SPIN, VX, VY, Aim
from omnipuck_sim.robot.engine import make_engine
from omnipuck_sim.robot.inertia import true_inertia
from omnipuck_sim.robot.physics import Simulator

NO_CIRCLES = np.zeros((0, 3))
QUIET = Settings(simulator=Simulation(noise=0.0))
RADIUS = QUIET.robot.radius
V_MAX = QUIET.robot.max_speed
RESTITUTION = QUIET.simulator.restitution
FRICTION = QUIET.simulator.friction
MASS, MOMENT = true_inertia(QUIET.robot, QUIET.simulator)


def make_world(polygons=(), circles=NO_CIRCLES, walled=False, bounds=(-5.0, -5.0, 5.0, 5.0), start=None) -> World:
    polygons = tuple(np.asarray(p, dtype=float) for p in polygons)
    circles = np.asarray(circles, dtype=float).reshape(-1, 3)
    return World(name="scene", polygons=polygons, circles=circles, bounds=bounds, walled=walled, start=start, goal=None)


WALL = make_world([[(0.5, -3.0), (1.0, -3.0), (1.0, 3.0), (0.5, 3.0)]])
"""One wall, met at x = 0.5 m."""


def quiet(**simulation) -> Settings:
    return replace(QUIET, simulator=Simulation(noise=0.0, **simulation))


def launched(world: World, position, velocity, settings: Settings = QUIET, seed: int = 0) -> Simulator:
    """Drive off: nothing but hits changes the velocity."""
    sim = Simulator(world, settings, seed, start=np.asarray(position, dtype=float))
    sim.place(np.asarray(position), np.asarray(velocity))
    sim.drive = False
    return sim


def flight(sim: Simulator, duration: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    states = []
    while sim.time < duration - 1e-9:
        sim.step()
        states.append(sim.state)
    return (
        np.array([s.stamp for s in states]),
        np.array([s.position for s in states]),
        np.array([s.velocity for s in states]),
    )


def hit(velocity, settings: Settings = QUIET, spin: float = 0.0) -> tuple[np.ndarray, float]:
    """Velocity (2,) and spin after a hit of WALL, 2 cm of flight after the begin."""
    disc = make_engine(WALL, settings.robot, settings.simulator, np.random.default_rng(0))
    speed, step = float(np.hypot(*velocity)), 1.0 / settings.simulator.physics_rate
    before = np.array([0.5 - RADIUS, 0.0]) - 0.02 * np.asarray(velocity) / speed
    disc.place(tuple(before.tolist()), tuple(np.asarray(velocity).tolist()), 0.0)
    disc.motion[SPIN] = spin
    for k in range(round((0.03 / speed + 2.0 * settings.simulator.contact_time) / step)):
        disc.advance(k, 1, Aim(drives=False))
    return disc.motion[[VX, VY]], float(disc.motion[SPIN])


def rigid_disc(velocity, spin, normal, simulation=QUIET.simulator) -> tuple[np.ndarray, float]:
    """Velocity and spin after a hit in closed form: Coulomb's friction, which a disc may roll off or slide along."""
    factor = QUIET.robot.inertia_factor
    tangent = np.array([-normal[1], normal[0]])
    into = -(velocity @ normal)
    slip = velocity @ tangent - spin * RADIUS
    change = -np.sign(slip) * min(simulation.friction * (1.0 + simulation.restitution) * into, abs(slip) * factor)
    inertia = factor / (1.0 - factor)  # I / (m r^2)
    after = velocity + (1.0 + simulation.restitution) * into * normal + change * tangent
    return after, spin - change / (inertia * RADIUS)


def energy(velocity, spin: float) -> float:
    return 0.5 * MASS * float(np.dot(velocity, velocity)) + 0.5 * MOMENT * spin**2


def energy_of(sim: Simulator) -> float:
    return energy(sim.state.velocity, sim.spin)


def unit(angle: float) -> np.ndarray:
    return np.array([np.cos(angle), np.sin(angle)])
