"""The robot's body among obstacles: a dynamic pymunk body with mass, inertia, restitution and friction, stepped.

Where nothing is near it flies free, without pymunk.
"""

from collections.abc import Iterable

import numpy as np
import pymunk

from collplan_core.impact import Impact
from collplan_core.parameters import Robot, Simulation
from collplan_core.worlds import World
from omnipuck_sim.robot.drive import VX, VY, Aim, X, Y, drive_law, flown, outline_of, push
from omnipuck_sim.robot.inertia import true_inertia
from omnipuck_sim.robot.vector import Vector
from omnipuck_sim.robot.walls import Edge, Pole, outlines

IMPACT_SPEED = 0.08
"""A contact begun faster than this into the wall is recorded as an impact [m/s]."""


class HitLaw:
    """Restitution may differ from wall to wall, restitution and friction from hit to hit."""

    def __init__(self, simulation: Simulation, surfaces: Iterable[int], random: np.random.Generator) -> None:
        """`random` draws the spread of each of the numbered surfaces, and of each hit."""
        self._simulation, self._random = simulation, random
        numbers = sorted(set(surfaces))
        draws = random.uniform(-1.0, 1.0, len(numbers)).tolist()
        self._factors = {
            number: 1.0 + simulation.wall_spread * draw for number, draw in zip(numbers, draws, strict=True)
        }

    def drawn(self) -> Vector:
        """Returns the random numbers of one hit."""
        spread, rough = self._random.uniform(-1.0, 1.0, 2).tolist()
        return spread, rough

    def of(self, surface: int, drawn: Vector) -> tuple[float, float]:
        """Restitution and friction of a hit on a surface."""
        simulation, (spread, rough) = self._simulation, drawn
        restitution = simulation.restitution * self._factors[surface] + spread * simulation.restitution_spread
        friction = simulation.friction + rough * simulation.friction_spread
        return min(max(restitution, 0.0), 1.0), max(friction, 0.0)


SLOP = 1e-4
"""Overlap that the solver leaves between body and wall [m]; pymunk's own is 0.1 m."""
SAME_CONTACT = 0.05
"""Impacts on one surface within this time count once [s]."""
BESIDE = 0.02
"""Distance of a mover below which steps are pymunk's [m]."""
BODY, WALL = 1, 2


class Disc:
    """One rigid disc in a space of its own; time passes only in `advance`.

    Restitution may differ from hit to hit and from wall to wall; what does the rebound is pymunk's solver.
    """

    def __init__(
        self,
        world: World,
        robot: Robot,
        simulation: Simulation,
        random: np.random.Generator,
        movers: np.ndarray,
    ) -> None:
        """`random` draws the spread of each hit and of each wall; movers as in `make_engine`."""
        self._simulation = simulation
        self._radius = robot.radius
        self._drive = drive_law(robot, simulation)
        self.motion = np.zeros(8)  # of the drive; may be set
        self._moved, self._touched = True, 0
        self._space = pymunk.Space()
        self._space.collision_slop = SLOP
        self._body = pymunk.Body(*true_inertia(robot, simulation))
        self._add_ring()
        pieces = list(outlines(world))
        self._constants = tuple(self._drive), outline_of(pieces, robot.radius)
        self._surface_of: dict[pymunk.Shape, int] = {}
        for piece in pieces:
            self._add_solid(_shape(piece, self._space.static_body), piece.surface)
        self._surfaces = 1 + max(self._surface_of.values(), default=-1)
        self._movers = movers
        self._walkers = [self._add_walker(number, radius) for number, radius in enumerate(movers[:, 4].tolist())]
        self._law = HitLaw(simulation, self._surface_of.values(), random)
        self._last_impact: dict[int, float] = {}
        self._begun: list[tuple[int, Vector, Vector, Vector, Vector]] = []
        self._impacts: list[Impact] = []
        self._space.on_collision(BODY, WALL, begin=self._begin, pre_solve=self._choose_hit)
        # compiled before time passes
        self._fly(0, Aim())
        push(self._drive, self.motion, Aim())

    def place(self, position: Vector, velocity: Vector, yaw: float) -> None:
        """Puts the disc at a position [m] with a velocity [m/s] and a yaw [rad], without spin."""
        self.motion[:] = *position, *velocity, yaw, 0.0, *velocity
        self._moved, self._touched = True, self._space.collision_persistence
        self._last_impact.clear()

    def advance(self, step: int, most: int, aim: Aim) -> int:
        """Moves on by physics step number `step` and maybe those after it, `most` in all; returns by how many."""
        # pymunk forgets a touch, whose impulses count for the next one's friction, some steps after it
        made = 0 if self._touched or self._is_beside_mover() else self._fly(most, aim)
        if made:
            self._moved = True
            return made
        body = self._body
        if self._moved:
            x, y, vx, vy, body.angle, body.angular_velocity = self.motion[:6].tolist()
            body.position, body.velocity = (x, y), (vx, vy)
            self._moved = False
        force_x, force_y, body.torque = push(self._drive, self.motion, aim)
        body.force = force_x, force_y
        self._touched = max(self._touched - 1, 0)
        for walker, (x, y, vx, vy, _) in zip(self._walkers, self._movers.tolist(), strict=True):
            walker.position, walker.velocity = (x, y), (vx, vy)
        self._space.step(1.0 / self._drive.rate)
        self.motion[:6] = *body.position, *body.velocity, body.angle, body.angular_velocity
        if self._begun:
            self._record((step + 1) / self._drive.rate)
        return 1

    def _fly(self, most: int, aim: Aim) -> int:
        law, outline = self._constants
        return int(flown(self.motion, law, tuple(aim), outline, most))

    def take_impacts(self) -> list[Impact]:
        """The impacts since the last call, in order."""
        taken, self._impacts = self._impacts, []
        return taken

    def _add_ring(self) -> None:
        ring = pymunk.Circle(self._body, self._radius)
        # pymunk multiplies what two shapes have: the walls' are 1
        ring.elasticity, ring.friction = self._simulation.restitution, self._simulation.friction
        ring.collision_type = BODY
        self._space.add(self._body, ring)

    def _add_solid(self, shape: pymunk.Shape, surface: int) -> None:
        shape.elasticity, shape.friction, shape.collision_type = 1.0, 1.0, WALL
        self._space.add(shape)
        self._surface_of[shape] = surface

    def _add_walker(self, number: int, radius: float) -> pymunk.Body:
        """A body that nothing pushes for a mover, whose surface comes after those of the walls."""
        walker = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        self._space.add(walker)
        self._add_solid(pymunk.Circle(walker, radius), self._surfaces + number)
        return walker

    def _is_beside_mover(self) -> bool:
        return any(
            (x - self.motion[X]) ** 2 + (y - self.motion[Y]) ** 2 < (self._radius + radius + BESIDE) ** 2
            for x, y, _, _, radius in self._movers.tolist()
        )

    def _begin(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        normal = arbiter.contact_point_set.normal
        point = arbiter.contact_point_set.points[0].point_b
        velocity, other = self._body.velocity, arbiter.shapes[1]
        relative = velocity - other.body.velocity
        of_contact = (point.x, point.y), (-normal.x, -normal.y), (velocity.x, velocity.y), (relative.x, relative.y)
        self._begun.append((self._surface_of[other], *of_contact))

    def _choose_hit(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        self._touched = self._space.collision_persistence
        if not arbiter.is_first_contact:
            return
        surface = self._surface_of[arbiter.shapes[1]]
        arbiter.restitution, arbiter.friction = self._law.of(surface, self._law.drawn())

    def _record(self, time: float) -> None:
        after = self.motion[[VX, VY]]
        for surface, point, normal, before, relative in self._begun:
            into = -(relative[0] * normal[0] + relative[1] * normal[1])
            if into <= IMPACT_SPEED or time - self._last_impact.get(surface, -np.inf) <= SAME_CONTACT:
                continue
            self._last_impact[surface] = time
            moves = surface >= self._surfaces
            vectors = np.array(point), np.array(normal), np.array(before), after
            self._impacts.append(Impact(time, *vectors, with_mover=moves))
        self._begun.clear()


def _shape(piece: Edge | Pole, body: pymunk.Body) -> pymunk.Shape:
    if isinstance(piece, Pole):
        return pymunk.Circle(body, piece.radius, piece.centre)
    return pymunk.Segment(body, piece.a, piece.b, 0.0)
