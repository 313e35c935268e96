"""The robot's body with a compliant ring, a planar body that MuJoCo steps, and its spring and damper."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import atan, atanh, ceil, log, pi

import mujoco
import numpy as np
from scipy.optimize import brentq

from collplan_core.impact import Impact
from collplan_core.parameters import Robot, Simulation
from collplan_core.worlds import World
from omnipuck_sim.robot.disc import IMPACT_SPEED, HitLaw
from omnipuck_sim.robot.drive import SPIN, VX, VY, YAW, Aim, X, Y, drive_law, push
from omnipuck_sim.robot.inertia import true_inertia
from omnipuck_sim.robot.vector import Vector
from omnipuck_sim.robot.walls import Edge, Pole, outlines

LEAST_RESTITUTION, MOST_RESTITUTION = 0.01, 0.999
"""Restitutions beyond are taken as these: with none at all the damper would have no end."""
SMALL = 1e-9


@lru_cache(maxsize=1024)
def spring_and_damper(contact_time: float, restitution: float) -> tuple[float, float]:
    """Stiffness [1/s^2] and damping [1/s], both by mass, of a linear ring in a hit head-on.

    Nothing sticks: the hit ends when the force is zero, which is before the ring has its shape back.
    Schwager and Poeschel 2007: Coefficient of restitution and linear-dashpot model revisited.
    """
    loss = -log(min(max(restitution, LEAST_RESTITUTION), MOST_RESTITUTION))
    return (loss**2 + _square_phase(loss)) / contact_time**2, 2.0 * loss / contact_time


def _square_phase(loss: float) -> float:
    """Square of the phase that the oscillation goes through in a hit; negative where it is overdamped."""
    if abs(loss - 2.0) < SMALL:
        return 0.0
    if loss < 2.0:
        return float(brentq(lambda phase: phase - 2.0 * atan(phase / loss), SMALL, pi)) ** 2
    return -(float(brentq(lambda phase: phase - 2.0 * atanh(phase / loss), SMALL, loss * (1.0 - SMALL))) ** 2)


LONGEST_STEP = 5e-4
"""MuJoCo's step is a whole fraction of a physics step and at most this [s]."""
NEAR = 0.003
"""Distance of a wall below which the properties of the coming hit are drawn [m]."""
EDGE_RADIUS = 1e-6
"""Edges are capsules of this radius [m]."""
IMPEDANCE = 0.9999
"""MuJoCo's largest: contacts accelerate the body as spring and damper say, whatever else pulls at it."""
SLIP_SHARE = 2.0 / 3.0
"""Time constant of the friction over the contact time. MuJoCo's friction is convex: one that stops the slip much faster
pushes the wall away too and takes from the restitution, a slower one does not stop it within a hit."""
SAME_CONTACT = 0.05
"""Impacts on one surface within this time after one ended count once [s]."""
LONGEST_CONTACT = 3.0
"""An impact of which the body does not come off ends after so many contact times."""
UNMOVED = 1e6
"""Mass of a mover, which no hit moves [kg]."""
RING = "ring"
PLACE, CHANGE = [X, Y, YAW], [VX, VY, SPIN]
"""Columns of a motion that correspond to MuJoCo's joints."""


@dataclass(eq=False)
class _Touch:
    """A contact with a surface that has begun; `before` is the velocity then, `after` the one at its end."""

    surface: int
    begun: float
    point: np.ndarray
    normal: np.ndarray
    before: np.ndarray
    after: np.ndarray | None = None

    def impact(self, walls: int) -> Impact:
        """The impact; surfaces from number `walls` on are of movers."""
        assert self.after is not None
        moves = self.surface >= walls
        return Impact(self.begun, self.point, self.normal, self.before, self.after, with_mover=moves)


class MujocoDisc:
    """One disc with a compliant ring in a model of its own; time passes only in `advance`.

    A hit lasts simulator.contact_time. Contact and friction are MuJoCo's; spring and damper are set for each hit, so
    that the restitution may differ from hit to hit and from wall to wall.
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
        step = 1.0 / simulation.physics_rate
        self._substeps = ceil(step / LONGEST_STEP - 1e-9)
        self._substep = step / self._substeps
        self._drive = drive_law(robot, simulation)
        self.motion = np.zeros(8)  # of the drive; may be set
        push(self._drive, self.motion, Aim())  # compiled before time passes
        pieces = list(outlines(world))
        self._movers = movers
        self._model = _model(pieces, robot, simulation, self._substep, movers[:, 4])
        self._data = mujoco.MjData(self._model)
        self._ring = self._model.geom(RING).id
        self._surfaces = [piece.surface for piece in pieces]
        self._walls = 1 + max(self._surfaces, default=-1)
        # each mover is a surface of its own
        self._surfaces += range(self._walls, self._walls + len(movers))
        self._velocities = np.zeros((len(self._surfaces), 2))
        self._law = HitLaw(simulation, self._surfaces, random)
        self._draws: dict[int, Vector] = {}
        self._touching: dict[int, _Touch] = {}
        self._ended: dict[int, float] = {}
        self._impacts: list[_Touch] = []

    def place(self, position: Vector, velocity: Vector, yaw: float) -> None:
        """Puts the disc at a position [m] with a velocity [m/s] and a yaw [rad], without spin."""
        mujoco.mj_resetData(self._model, self._data)
        self.motion[:] = *position, *velocity, yaw, 0.0, *velocity
        self._draws.clear()
        self._touching.clear()
        self._ended.clear()
        self._impacts = [touch for touch in self._impacts if touch.after is not None]

    def advance(self, step: int, most: int, aim: Aim) -> int:
        """Moves on by physics step number `step`; returns 1."""
        data, time = self._data, (step + 1) / self._drive.rate
        walked = len(data.qpos) - len(PLACE)
        data.qpos[:walked], data.qvel[:walked] = self._movers[:, :2].ravel(), self._movers[:, 2:4].ravel()
        self._velocities[len(self._surfaces) - len(self._movers) :] = self._movers[:, 2:4]
        data.qpos[walked:], data.qvel[walked:] = self.motion[PLACE], self.motion[CHANGE]
        data.qfrc_applied[walked:] = push(self._drive, self.motion, aim)
        for left in reversed(range(self._substeps)):
            before = self._velocity
            mujoco.mj_step(self._model, data)
            if data.ncon or self._touching:
                self._follow_contacts(time - left * self._substep, before)
        self.motion[PLACE], self.motion[CHANGE] = data.qpos[walked:], data.qvel[walked:]
        return 1

    @property
    def _velocity(self) -> np.ndarray:
        """Velocity (2,) of the ring's centre: its joints are the last ones [m/s]."""
        return self._data.qvel[-3:-1].copy()

    def take_impacts(self) -> list[Impact]:
        """Returns the impacts since the last call, in order of their begin; each is returned once it has ended."""
        taken = []
        while self._impacts and self._impacts[0].after is not None:
            taken.append(self._impacts.pop(0).impact(self._walls))
        return taken

    def _follow_contacts(self, time: float, before: np.ndarray) -> None:
        """Takes contacts near, begun and ended in the substep up to `time`, entered with the velocity `before`."""
        found = self._data.contact
        listed, touched = set(), set()
        for (first, second), distance, frame, point in zip(
            found.geom.tolist(), found.dist.tolist(), found.frame, found.pos, strict=True
        ):
            piece, normal = (second, -frame[:2]) if first == self._ring else (first, frame[:2].copy())
            listed.add(piece)
            if distance >= 0.0:
                self._choose_hit(piece, normal)
                continue
            surface = self._surfaces[piece]
            touched.add(surface)
            if surface not in self._touching:
                at = point[:2] - 0.5 * distance * normal
                self._begin(_Touch(surface, time, at, normal, before), self._velocities[piece])
        for piece in self._draws.keys() - listed:
            del self._draws[piece]
        for surface in self._touching.keys() - touched:
            self._end(self._touching.pop(surface), time)
        for touch in self._touching.values():
            if touch.after is None and time - touch.begun > LONGEST_CONTACT * self._simulation.contact_time:
                self._end(touch, time)

    def _choose_hit(self, piece: int, normal: np.ndarray) -> None:
        """Spring, damper and friction of the hit that would come now."""
        if piece not in self._draws:
            self._draws[piece] = self._law.drawn()
        restitution, friction = self._law.of(self._surfaces[piece], self._draws[piece])
        self._model.pair_solref[piece] = _solref(self._simulation, restitution)
        self._model.pair_friction[piece, :2] = friction

    def _begin(self, touch: _Touch, other: np.ndarray) -> None:
        """Takes a touch of what has a velocity `other` (2,) [m/s]."""
        self._touching[touch.surface] = touch
        again = touch.begun - self._ended.get(touch.surface, -np.inf) <= SAME_CONTACT
        if -((touch.before - other) @ touch.normal) > IMPACT_SPEED and not again:
            self._impacts.append(touch)

    def _end(self, touch: _Touch, time: float) -> None:
        if touch.after is None:
            touch.after = self._velocity
        if any(touch is impact for impact in self._impacts):
            self._ended[touch.surface] = time


def _model(
    pieces: Sequence[Edge | Pole], robot: Robot, simulation: Simulation, step: float, movers: np.ndarray
) -> mujoco.MjModel:
    """Model of the plane: a sphere that slides and turns in it, what is solid, and movers of radii (k,) [m]."""
    # geoms of pieces, then of movers, and their pairs with the ring are numbered in this order; its joints are the last
    mass, moment = true_inertia(robot, simulation)
    spec = mujoco.MjSpec()
    option = spec.option
    option.timestep, option.gravity, option.cone = step, (0.0, 0.0, 0.0), mujoco.mjtCone.mjCONE_ELLIPTIC
    for number, piece in enumerate(pieces):
        ends, thickness = _capsule(piece)
        spec.worldbody.add_geom(
            name=str(number), type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=ends, size=(thickness, 0.0, 0.0)
        )
    for number, radius in enumerate(movers.tolist(), len(pieces)):
        walker = _sliding(spec, UNMOVED, UNMOVED)
        # without pairs of its own but that with the ring
        walker.add_geom(
            name=str(number), type=mujoco.mjtGeom.mjGEOM_SPHERE, size=(radius, 0.0, 0.0), contype=0, conaffinity=0
        )
    body = _sliding(spec, mass, moment)
    body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=(0.0, 0.0, 1.0))
    body.add_geom(name=RING, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=(robot.radius, 0.0, 0.0))
    for number in range(len(pieces) + len(movers)):
        spec.add_pair(
            name=str(number),
            geomname1=RING,
            geomname2=str(number),
            condim=3,
            gap=NEAR,
            solref=_solref(simulation, simulation.restitution),
            solreffriction=(SLIP_SHARE * simulation.contact_time, 1.0),
            friction=(simulation.friction, simulation.friction, 0.0, 0.0, 0.0),
            solimp=(IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0),
        )
    return spec.compile()


def _sliding(spec: mujoco.MjSpec, mass: float, moment: float) -> mujoco.MjsBody:
    body = spec.worldbody.add_body(mass=mass, inertia=(moment, moment, moment), explicitinertial=True)
    for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)):
        body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
    return body


def _solref(simulation: Simulation, restitution: float) -> Vector:
    """MuJoCo's parameters of a contact."""
    stiffness, damping = spring_and_damper(simulation.contact_time, restitution)
    # negative numbers are stiffness and damping, positive ones would be a time constant and a damping ratio
    return -stiffness, -damping


def _capsule(piece: Edge | Pole) -> tuple[tuple[float, ...], float]:
    """Ends of the axis (6) and radius of a capsule [m]."""
    if isinstance(piece, Pole):
        return (*piece.centre, -1.0, *piece.centre, 1.0), piece.radius
    return (*piece.a, 0.0, *piece.b, 0.0), EDGE_RADIUS
