"""The simulated robot and its sensors, one control period at a time."""

from typing import NamedTuple

import numpy as np

from collplan_core.control.follow import cut_to_bounds, hold_heading
from collplan_core.impact import Impact
from collplan_core.parameters import ParameterError, Settings
from collplan_core.poses import pose_filter
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.velocity_bounds import velocity_bounds
from collplan_core.worlds import World
from collplan_core.worlds.instant_lidar import InstantLidar, MoverHistory
from omnipuck_sim.robot.physics import Simulator


class Measured(NamedTuple):
    """Measurements of a control period."""

    states: tuple[State, ...]  # from the poses of motion capture, in order
    newest: State  # the last of them; without any, the previous one
    changes: tuple[tuple[float, np.ndarray], ...]  # impacts in these poses: stamp [s] and change of velocity (2,) [m/s]
    scan: Scan  # from the newest pose
    contacts: tuple[Impact, ...]  # the true impacts


class MeasuredRobot:
    """A robot in a world that has a start, commanded once a control period; poses and scans come at once.

    ParameterError: a sensor that needs time, which is not simulated here, or rates at which a control period would last
    another time than 1 / controller.rate.
    """

    def __init__(self, world: World, settings: Settings, seed: int) -> None:
        if settings.lidar.sensor != "ideal":
            raise ParameterError(f"lidar.sensor: got {settings.lidar.sensor}, expected ideal")
        if settings.simulator.mocap_latency > 0.0:
            raise ParameterError(f"simulator.mocap_latency: got {settings.simulator.mocap_latency}, expected 0")
        self._settings = settings
        self._simulator = Simulator(world, settings, seed)
        self._movers = MoverHistory()
        self._lidar = InstantLidar(world, settings.lidar, seed, self._movers)
        self._filter = pose_filter.FRESH
        self._newest = self._simulator.state
        poses = _periods(settings, "simulator.mocap_rate", "controller.rate")
        self._between_poses = _periods(settings, "simulator.physics_rate", "simulator.mocap_rate")
        self._period = poses * self._between_poses

    def rest(self) -> Measured:
        """Runs a control period without a command, which fills the window of the pose filter."""
        return self._advance()

    def drive(self, velocity: np.ndarray, yaw: float) -> Measured:
        """Runs a control period under a finite velocity (2,) [m/s, body frame], cut to v_max; the heading is held at 0.

        `yaw` is the heading measured last [rad].
        """
        turn = hold_heading(yaw, 0.0)
        self._simulator.command(cut_to_bounds(velocity, velocity_bounds(self._settings.robot)), turn)
        return self._advance()

    def _advance(self) -> Measured:
        states, changes = list[State](), list[tuple[float, np.ndarray]]()
        for _ in range(0, self._period, self._between_poses):
            self._simulator.step(self._between_poses)
            sample = self._simulator.measured_pose()
            self._movers.add(sample.stamp, self._simulator.movers[:, [0, 1, 4]])
            result, self._filter = pose_filter.filter_pose(self._filter, sample, sample.stamp, self._settings)
            if result.state is not None:
                states.append(result.state)
            if result.impact is not None:
                changes.append((sample.stamp, result.impact.change))
        self._newest = newest = states[-1] if states else self._newest
        contacts = tuple(self._simulator.take_impacts())
        return Measured(tuple(states), newest, tuple(changes), self._lidar.scan(newest), contacts)


def _periods(settings: Settings, fast: str, slow: str) -> int:
    """How many periods of one rate a period of another one lasts; ParameterError where it is no whole number."""
    rate, other = settings.values()[fast], settings.values()[slow]
    periods = round(rate / other)
    if periods < 1 or abs(rate / other - periods) > 1e-6:
        raise ParameterError(f"{slow}: got {other:g} Hz, expected {fast}, {rate:g} Hz, divided by a whole number")
    return periods
