"""The simulated Omnipuck: a disc among obstacles that a physics engine steps, pushed by wheels that lag."""

from math import ceil, isfinite, pi, remainder

import numpy as np

from collplan_core.impact import Impact
from collplan_core.parameters import Settings
from collplan_core.poses.mocap_body import on_tilted_floor, with_offset
from collplan_core.poses.pose_filter import PoseSample
from collplan_core.state import State
from collplan_core.worlds import World, WorldError
from collplan_core.worlds.route import check_movers_apart, clearance, touch_depth
from omnipuck_sim.robot.drive import SPIN, VX, VY, YAW, Aim, X, Y
from omnipuck_sim.robot.engine import make_engine
from omnipuck_sim.robot.noise import ACTUATION_RATE, Noise
from omnipuck_sim.robot.vector import Vector
from omnipuck_sim.robot.walks import Touch, Walks

CLEAR = 1e-6
"""Least distance from every obstacle at which a noisy start is drawn [m]."""

MOST_STARTS = 1000
"""Noisy starts that are drawn until one is free."""


class Simulator:
    """The simulated robot in its world, and what walks there; time passes only in `step`.

    A walled world's bounds are solid too. Of the settings robot, simulator, limits.command_age and controller.rate are
    used. Equal seeds give equal runs, bit by bit. The start (2,) [m], by default the world's own, is moved by noise.

    Raises:
        WorldError: no start given, or the robot or a mover would stand inside an obstacle or in one another.
        ParameterError: simulator.engine is not installed.
    """

    def __init__(self, world: World, settings: Settings, seed: int, start: np.ndarray | None = None) -> None:
        self._rate = settings.simulator.physics_rate
        self._radius = settings.robot.radius
        self._world = world
        self._steps_a_draw = self._rate / ACTUATION_RATE
        self._noise = Noise(settings.simulator, seed)
        markers = settings.simulator
        self._marker_offset = markers.marker_offset_x, markers.marker_offset_y, markers.marker_offset_yaw
        self._floor_tilt = markers.floor_tilt
        self._walks = Walks(world, settings)
        self._disc = make_engine(world, settings.robot, settings.simulator, self._noise.rebound, self._walks.discs)
        self._command_life = settings.limits.command_age + 1.0 / settings.controller.rate
        self._steps = 0
        self._draws = 0
        self._error: Vector = (0.0, 0.0)
        self.drive = True
        """True where the wheels drive; without them nothing but impacts changes the velocity."""
        self._start = self._drawn_start(world, start)
        self.reset()

    @property
    def time(self) -> float:
        """Simulated time, an exact multiple of the step [s]."""
        return self._steps / self._rate

    @property
    def state(self) -> State:
        """The true state now, world frame."""
        motion = self._disc.motion
        return State(self.time, motion[[X, Y]], motion[[VX, VY]], self._yaw)

    @property
    def movers(self) -> np.ndarray:
        """(k, 5) x, y [m], vx, vy [m/s], radius [m] of each mover, the truth now."""
        return self._walks.discs.copy()

    @property
    def _yaw(self) -> float:
        return remainder(self._disc.motion[YAW], 2 * pi)

    @property
    def spin(self) -> float:
        """The true yaw rate [rad/s]."""
        return float(self._disc.motion[SPIN])

    def reset(self) -> None:
        """Puts the robot back to the start, at rest, without a command. Time and noise go on."""
        self.place(np.array(self._start))

    def place(self, position: np.ndarray, velocity: np.ndarray | None = None, yaw: float = 0.0) -> None:
        """Puts the robot at a position (2,) [m] with a velocity (2,) [m/s, world frame] and a yaw [rad].

        WorldError: inside an obstacle.
        """
        x, y = np.asarray(position, dtype=float).tolist()
        self._check_free((x, y))
        vx, vy = (0.0, 0.0) if velocity is None else np.asarray(velocity, dtype=float).tolist()
        self._disc.place((x, y), (vx, vy), yaw)
        self._halt()

    def command(self, velocity_body: np.ndarray, yaw_rate: float, age: float = 0.0) -> None:
        """Takes a velocity (2,) [m/s, body frame] and a yaw rate [rad/s] of this age [s], in force from now on.

        The body zeroes them once they are older than limits.command_age and one controller period, unless another
        command comes. ValueError: not finite.
        """
        x, y = np.asarray(velocity_body, dtype=float).tolist()
        if not (isfinite(x) and isfinite(y) and isfinite(yaw_rate)):
            raise ValueError(f"command: got {x}, {y}, {yaw_rate}, expected finite numbers")
        self._command: Vector = (x, y)
        self._yaw_rate = float(yaw_rate)
        self._expires = self.time + self._command_life - age

    def step(self, steps: int = 1) -> None:
        """Advances the simulation by `steps` physics steps of 1 / simulator.physics_rate [s] each."""
        end = self._steps + steps
        while self._steps < end:
            # half a step of tolerance in both: sums of decimal times must not decide
            if self._steps > self._expires * self._rate - 0.5:
                self._halt()
            if self._steps >= self._draws * self._steps_a_draw - 0.5:
                self._error = self._noise.actuation()
                self._draws += 1
            until = min(end, self._draws * self._steps_a_draw - 0.5, self._expires * self._rate - 0.5)
            aim = Aim(*self._command, self._yaw_rate, *self._error, self.drive)
            if not self._world.movers:
                self._steps += self._disc.advance(self._steps, max(ceil(until) - self._steps, 1), aim)
                continue
            self._walks.begin(self.time, self._disc.motion.tolist())
            self._steps += self._disc.advance(self._steps, 1, aim)
            self._walks.end()

    def take_impacts(self) -> list[Impact]:
        """The impacts since the last call, in order."""
        return self._disc.take_impacts()

    def take_touches(self) -> list[Touch]:
        """The touches of movers since the last call, in order."""
        taken, self._walks.touches = self._walks.touches, []
        return taken

    def measured_pose(self) -> PoseSample:
        """The pose that the motion capture measures now: that of the body of markers on the robot, with noise."""
        robot = PoseSample(self.time, self._disc.motion[[X, Y]] + self._noise.mocap(), self._yaw)
        body = with_offset(robot, *self._marker_offset)
        turned = PoseSample(body.stamp, body.position, remainder(body.yaw + self._noise.mocap_yaw(), 2 * pi))
        return on_tilted_floor(turned, *self._floor_tilt) if any(self._floor_tilt) else turned

    def _halt(self) -> None:
        self._command = (0.0, 0.0)
        self._yaw_rate = 0.0
        self._expires = float("inf")

    def _drawn_start(self, world: World, start: np.ndarray | None) -> Vector:
        chosen = world.start if start is None else start
        if chosen is None:
            raise WorldError(f"start: world {world.called} has none, expected one in the world or a start given")
        x, y = np.asarray(chosen, dtype=float).tolist()
        self._check_free((x, y))
        check_movers_apart(world, np.array((x, y)), self._radius)
        for _ in range(MOST_STARTS):
            noise_x, noise_y = self._noise.start()
            if clearance(world, np.array((x + noise_x, y + noise_y)), self._radius) > CLEAR:
                return x + noise_x, y + noise_y
        return x, y

    def _check_free(self, position: Vector) -> None:
        if not (isfinite(position[0]) and isfinite(position[1])):
            raise WorldError(f"start: got {position}, expected finite coordinates")
        depth = -clearance(self._world, np.array(position), self._radius)
        if depth > touch_depth(self._world):
            raise WorldError(
                f"start: the robot at ({position[0]:g}, {position[1]:g}) stands {depth:.3g} m inside an obstacle"
                f" or wall, expected free space for a disc of radius {self._radius:g} m"
            )
