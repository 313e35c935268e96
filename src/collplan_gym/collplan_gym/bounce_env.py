"""`collplan/Bounce-v0`: reach a goal in an unknown place in the least time; contact costs nothing but what it does."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from collplan_core.parameters import Settings
from collplan_core.plane import rotate
from collplan_core.poses.impact_detection import top_speed
from collplan_core.validation import check_type, finite
from collplan_core.worlds import World, WorldError, load_world
from collplan_core.worlds.families import FAMILIES
from collplan_gym.measured_robot import Measured, MeasuredRobot

MOST_SEEDS = 2**31
"""Seeds of worlds and noise are drawn below this."""
LONGEST_REST = 20
"""Control periods within which a robot at rest is found by its poses."""
Observation = dict[str, np.ndarray]


class BounceEnv(gymnasium.Env[Observation, np.ndarray]):
    """The Omnipuck, a puck with a reflection ring, on its way to a goal; one step is one control period (0.05 s).

    Observation, in the robot's frame: `scan` (n_beams,) ranges [m], range_max where nothing is seen, beam k at
    lidar.angle_min + k lidar.angle_span / n_beams, which is -pi for the first one, counter-clockwise; `velocity` (2,)
    [m/s]; `goal` (2,) from the robot to the goal [m]. Action: velocity (2,) [m/s], cut to v_max. Reward: minus the
    time that passed [s]. Terminates within planner.goal_tolerance of the goal, truncates after trial.timeout.

    `info` has `pose` (3,) x, y [m], yaw [rad] and `stamp` [s] of the newest pose; `contacts`, the number of impacts in
    the step, and `contact_speed`, the hardest one into its wall [m/s]. `PlannerPolicy` takes `states`, a tuple (stamp,
    x, y, vx, vy, yaw) for each pose, and `changes`, (stamp, change of vx, of vy) for each impact that the poses show.

    The world is a NAME, FILE, FAMILY:SEED or a World; a FAMILY alone draws a new world of it at each reset. Without
    settings it has the shipped ones. After `reset` it cannot be copied or pickled: make another one.

    Raises:
        TypeError: world or settings are of another type.
        WorldError: no such world, or one without start or goal.
        ValueError: a `render_mode`: nothing is drawn.
        ParameterError: a sensor that is not simulated here.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012  # gymnasium's own form

    def __init__(
        self,
        world: str | Path | World = "serpentine",
        settings: Settings | None = None,
        render_mode: str | None = None,
    ) -> None:
        self._settings = Settings() if settings is None else settings
        check_type("settings", self._settings, Settings, ", as in Settings()")
        check_type("world", world, str | Path | World, ", as in 'u:7'")
        if render_mode is not None:
            raise ValueError(f"render_mode: got {render_mode!r}, expected None: nothing is drawn")
        self.render_mode = None
        self._family = FAMILIES.get(world) if isinstance(world, str) else None
        self._world = world if isinstance(world, World) or self._family else load_world(world)
        lidar, speed = self._settings.lidar, self._settings.robot.max_speed
        n, far, fastest = lidar.n_beams, lidar.range_max, 2.0 * top_speed(self._settings.robot)
        self.observation_space = spaces.Dict(
            scan=spaces.Box(0.0, far, (n,), np.float32),
            velocity=spaces.Box(-fastest, fastest, (2,), np.float32),
            goal=spaces.Box(-np.inf, np.inf, (2,), np.float32),
        )
        self.action_space = spaces.Box(-speed, speed, (2,), np.float32)
        self._robot: MeasuredRobot | None = None
        self._goal, self._yaw, self._began = np.zeros(2), 0.0, 0.0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Starts a new episode: the robot rests at the start of its world."""
        super().reset(seed=int(seed) if isinstance(seed, np.integer) else seed)
        if self._family is not None:
            self._world = self._family(int(self.np_random.integers(MOST_SEEDS)))
        world = self._world
        assert isinstance(world, World)
        if world.goal is None:
            raise WorldError(f"{world.called}: goal: missing, expected x, y")
        self._goal = np.asarray(world.goal, dtype=float)
        self._robot = MeasuredRobot(world, self._settings, int(self.np_random.integers(MOST_SEEDS)))
        measured = self._robot.rest()
        for _ in range(LONGEST_REST):
            if measured.states:
                break
            measured = self._robot.rest()
        self._began = measured.states[-1].stamp
        return self._seen(measured)

    def __getstate__(self) -> dict[str, Any]:
        """State to be pickled or copied; TypeError after `reset`: the robot holds generators and an engine."""
        if self._robot is not None:
            raise TypeError("collplan/Bounce-v0: cannot be copied or pickled after reset, expected a new environment")
        return self.__dict__

    def step(self, action: np.ndarray) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Runs a control period under a velocity (2,) [m/s, body frame].

        ValueError: not finite, or `reset` was not called.
        """
        velocity = finite("action", action, (2,), "expected 2 finite numbers [m/s]")
        if self._robot is None:
            raise ValueError("step: called before reset")
        measured = self._robot.drive(velocity, self._yaw)
        observation, info = self._seen(measured)
        limits = self._settings
        arrived = any(
            np.hypot(*(each.position - self._goal)) <= limits.planner.goal_tolerance for each in measured.states
        )
        late = info["stamp"] - self._began >= limits.trial.timeout
        return observation, -1.0 / limits.controller.rate, arrived, late and not arrived, info

    def _seen(self, measured: Measured) -> tuple[Observation, dict[str, Any]]:
        state = measured.newest
        self._yaw = state.yaw
        found = {
            "scan": measured.scan.ranges,
            "velocity": np.array(rotate(*state.velocity.tolist(), -state.yaw)),
            "goal": np.array(rotate(*(self._goal - state.position).tolist(), -state.yaw)),
        }
        boxes = self.observation_space.spaces
        observation = {key: np.clip(found[key], box.low, box.high).astype(np.float32) for key, box in boxes.items()}
        into = [-float(each.velocity_before @ each.normal) for each in measured.contacts]
        info = {
            "pose": np.array([*state.position, state.yaw]),
            "stamp": state.stamp,
            "contacts": len(into),
            "contact_speed": max(into, default=0.0),
            "states": tuple((s.stamp, *s.position.tolist(), *s.velocity.tolist(), s.yaw) for s in measured.states),
            "changes": tuple((stamp, *change.tolist()) for stamp, change in measured.changes),
        }
        return observation, info
