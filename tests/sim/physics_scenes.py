"""Small worlds and flights that the physics tests share."""

from dataclasses import replace

import numpy as np

from collplan_core.parameters import Settings, Simulation
from collplan_core.worlds import World
from omnipuck_sim.robot.physics import Simulator

NO_CIRCLES = np.zeros((0, 3))
QUIET = Settings(simulator=Simulation(noise=0.0))
RADIUS = QUIET.robot.radius
RESTITUTION = QUIET.simulator.restitution
FRICTION = QUIET.simulator.friction


def make_world(polygons=(), circles=NO_CIRCLES, walled=False, bounds=(-5.0, -5.0, 5.0, 5.0), start=None) -> World:
    polygons = tuple(np.asarray(p, dtype=float) for p in polygons)
    circles = np.asarray(circles, dtype=float).reshape(-1, 3)
    return World(name="scene", polygons=polygons, circles=circles, bounds=bounds, walled=walled, start=start, goal=None)


def quiet(**simulation) -> Settings:
    return replace(QUIET, simulator=Simulation(noise=0.0, **simulation))


def launched(world: World, position, velocity, settings: Settings = QUIET, seed: int = 0) -> Simulator:
    """Drive off: nothing but hits changes the velocity."""
    sim = Simulator(world, settings, seed, start=np.asarray(position, dtype=float))
    sim.place(np.asarray(position), np.asarray(velocity))
    sim.drive = False
    return sim


def flight(sim: Simulator, duration: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (n,), positions (n, 2) and velocities (n, 2) after each step."""
    states = []
    while sim.time < duration - 1e-9:
        sim.step()
        states.append(sim.state)
    return (
        np.array([s.stamp for s in states]),
        np.array([s.position for s in states]),
        np.array([s.velocity for s in states]),
    )


def energy_of(sim: Simulator) -> float:
    """Kinetic energy, spin included [J]."""
    body = sim._disc.body
    vx, vy = body.velocity
    return 0.5 * body.mass * (vx**2 + vy**2) + 0.5 * body.moment * body.angular_velocity**2


def unit(angle: float) -> np.ndarray:
    return np.array([np.cos(angle), np.sin(angle)])
