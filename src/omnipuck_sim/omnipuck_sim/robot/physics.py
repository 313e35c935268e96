"""The simulated Omnipuck: a disc among solid obstacles, driven by wheels that lag, rebounding off what it meets."""

from math import floor, isfinite, pi, remainder

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.plane import rotate
from collplan_core.sensing.mocap_body import with_offset
from collplan_core.sensing.pose_filter import PoseSample
from collplan_core.state import State
from collplan_core.worlds import World, WorldError
from omnipuck_sim.robot.actuation import Wheels
from omnipuck_sim.robot.noise import ACTUATION_RATE, Noise
from omnipuck_sim.robot.obstacles import Contact, Obstacles
from omnipuck_sim.robot.rebound import IMPACT_SPEED, Impact, Ring, closing_speed, slide
from omnipuck_sim.robot.vector import Vector

GAP = 1e-6
"""Left between robot and wall at a contact, so that the next step starts from free space [m]."""

SAME_CONTACT = 0.05
"""Impacts on one surface within this time count once [s]."""

MOST_CONTACTS = 16
"""Contacts in one step; a robot wedged deeper into a corner rests for the remainder of the step."""

MOST_STARTS = 1000
"""Noisy starts that are drawn until one is free."""


class Simulator:
    """The simulated robot in its world; time passes only in `step`.

    Args:
        world: what is solid; the bounds are too where it is walled.
        settings: uses robot, simulator, limits.command_age and controller.rate.
        seed: seed of every random number; equal seeds give equal runs, bit by bit.
        start: (2,) [m], else the world's own; the start noise comes on top.

    Raises:
        WorldError: no start given, or the robot would stand inside an obstacle.
    """

    def __init__(self, world: World, settings: Settings, seed: int, start: np.ndarray | None = None) -> None:
        self._rate = settings.simulator.physics_rate
        self._radius = settings.robot.radius
        self._obstacles = Obstacles(world, settings.robot.radius)
        self._noise = Noise(settings.simulator, seed)
        markers = settings.simulator
        self._marker_offset = markers.marker_offset_x, markers.marker_offset_y, markers.marker_offset_yaw
        self._ring = Ring(settings.simulator, self._noise.rebound)
        self._wheels = Wheels(settings.robot, 1.0 / self._rate)
        self._command_life = settings.limits.command_age + 1.0 / settings.controller.rate
        self._steps = 0
        self._drawn = -1
        self._error: Vector = (0.0, 0.0)
        self._impacts: list[Impact] = []
        self.drive = True
        """Whether the wheels drive; without them nothing but impacts changes the velocity."""
        self._start = self._drawn_start(world, start)
        self.reset()

    @property
    def time(self) -> float:
        """Simulated time, an exact multiple of the step [s]."""
        return self._steps / self._rate

    @property
    def state(self) -> State:
        """The true state now, world frame."""
        return State(self.time, np.array(self._position), np.array(self._velocity), self._yaw)

    def reset(self) -> None:
        """Back to the start, at rest, without a command. Time and noise go on."""
        self.place(np.array(self._start))

    def place(self, position: np.ndarray, velocity: np.ndarray | None = None, yaw: float = 0.0) -> None:
        """Puts the robot at a position (2,) [m] with a velocity (2,) [m/s, world frame] and a yaw [rad].

        Raises:
            WorldError: inside an obstacle.
        """
        x, y = np.asarray(position, dtype=float).tolist()
        self._check_free((x, y))
        vx, vy = (0.0, 0.0) if velocity is None else np.asarray(velocity, dtype=float).tolist()
        self._position: Vector = (x, y)
        self._velocity: Vector = (vx, vy)
        self._yaw = yaw
        self._last_impact: dict[int, float] = {}
        self._halt()

    def command(self, velocity_body: np.ndarray, yaw_rate: float) -> None:
        """Takes a velocity (2,) [m/s, body frame] and a yaw rate [rad/s], in force from now on.

        The body zeroes them limits.command_age and one controller period later, unless another one comes.

        Raises:
            ValueError: not finite.
        """
        x, y = np.asarray(velocity_body, dtype=float).tolist()
        if not (isfinite(x) and isfinite(y) and isfinite(yaw_rate)):
            raise ValueError(f"command: got {x}, {y}, {yaw_rate}, expected finite numbers")
        self._command: Vector = (x, y)
        self._yaw_rate = float(yaw_rate)
        self._expires = self.time + self._command_life

    def step(self) -> None:
        """One physics step, 1 / simulator.physics_rate."""
        self._expire_command()
        self._draw_error()
        if self.drive:
            self._velocity = self._wheels.next_velocity(self._velocity, self._wanted())
        if self._velocity != (0.0, 0.0):
            self._move()
        if self._yaw_rate:
            self._yaw = remainder(self._yaw + self._yaw_rate / self._rate, 2 * pi)
        self._steps += 1

    def take_impacts(self) -> list[Impact]:
        """The impacts since the last call, in order."""
        taken, self._impacts = self._impacts, []
        return taken

    def measured_pose(self) -> PoseSample:
        """The pose that the motion capture measures now: that of the body of markers on the robot, with noise."""
        x, y = self._position
        noise_x, noise_y = self._noise.mocap()
        robot = PoseSample(self.time, np.array([x + noise_x, y + noise_y]), self._yaw)
        return with_offset(robot, *self._marker_offset)

    def _halt(self) -> None:
        self._command = (0.0, 0.0)
        self._yaw_rate = 0.0
        self._expires = float("inf")

    def _expire_command(self) -> None:
        # half a step of tolerance: sums of decimal times must not decide
        if self.time > self._expires - 0.5 / self._rate:
            self._halt()

    def _draw_error(self) -> None:
        due = floor((self._steps + 0.5) * ACTUATION_RATE / self._rate)
        while self._drawn < due:
            self._error = self._noise.actuation()
            self._drawn += 1

    def _wanted(self) -> Vector:
        """Velocity that the wheels aim at [m/s, world frame]; without noise where the command is zero."""
        if self._command == (0.0, 0.0):
            return 0.0, 0.0
        x, y = rotate(*self._command, self._yaw)
        return x + self._error[0], y + self._error[1]

    def _move(self) -> None:
        begun = 0.0
        for _ in range(MOST_CONTACTS):
            duration = (1.0 - begun) / self._rate
            end = self._after(duration)
            contact = self._obstacles.first_contact(self._position, end)
            if contact is None:
                self._position = end
                return
            touched = self._approach(contact, duration)
            begun += touched * (1.0 - begun)
            self._touch(contact, (self._steps + begun) / self._rate)

    def _after(self, duration: float) -> Vector:
        (x, y), (vx, vy) = self._position, self._velocity
        return x + vx * duration, y + vy * duration

    def _approach(self, contact: Contact, duration: float) -> float:
        """Moves up to the contact, but for the gap; returns the share of the duration used."""
        if contact.share == 0.0:
            (x, y), (nx, ny), lift = self._position, contact.normal, contact.depth + GAP
            self._position = x + lift * nx, y + lift * ny
            return 0.0
        into = closing_speed(self._velocity, contact.normal)
        share = max(contact.share - GAP / (into * duration), 0.0)
        self._position = self._after(share * duration)
        return share

    def _touch(self, contact: Contact, time: float) -> None:
        before = self._velocity
        if closing_speed(before, contact.normal) <= IMPACT_SPEED:
            self._velocity = slide(before, contact.normal)
            return
        self._velocity = self._ring.velocity_after(before, contact.normal)
        if time - self._last_impact.get(contact.surface, -np.inf) > SAME_CONTACT:
            self._last_impact[contact.surface] = time
            self._impacts.append(self._impact(contact, time, before))

    def _impact(self, contact: Contact, time: float, before: Vector) -> Impact:
        normal = np.array(contact.normal)
        point = np.array(self._position) - self._radius * normal
        return Impact(time, point, normal, np.array(before), np.array(self._velocity))

    def _drawn_start(self, world: World, start: np.ndarray | None) -> Vector:
        chosen = world.start if start is None else start
        if chosen is None:
            raise WorldError(f"start: world {world.name} has none, expected one in the world or a start given")
        x, y = np.asarray(chosen, dtype=float).tolist()
        self._check_free((x, y))
        for _ in range(MOST_STARTS):
            noise_x, noise_y = self._noise.start()
            if self._obstacles.clearance((x + noise_x, y + noise_y)) > GAP:
                return x + noise_x, y + noise_y
        return x, y

    def _check_free(self, position: Vector) -> None:
        if not (isfinite(position[0]) and isfinite(position[1])):
            raise WorldError(f"start: got {position}, expected finite coordinates")
        clearance = self._obstacles.clearance(position)
        if not clearance > 0.0:
            raise WorldError(
                f"start: the robot at ({position[0]:g}, {position[1]:g}) stands {-clearance:.3g} m inside an obstacle"
                f" or wall, expected free space for a disc of radius {self._radius:g} m"
            )
