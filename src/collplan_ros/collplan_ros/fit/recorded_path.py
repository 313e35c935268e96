"""The path of a recorded run, as fits need it."""

from dataclasses import dataclass

import numpy as np

from collplan_core.calibration.impact_fit import RecordedPath
from collplan_core.parameters import Settings
from collplan_core.plane import rotate_rows
from collplan_core.worlds import World
from collplan_ros.run.recorded_run import RecordedRun
from collplan_ros.run.whole_file import RunError


@dataclass(frozen=True, eq=False)
class FittedRun:
    """A run that constants are fitted to.

    Attributes:
        name: path of the run folder.
        simulated: whether the robot was simulated.
        settings: the parameters used.
        world: the world that the robot was in.
        path: poses and commands; t counts from the first non-zero command.
        yaws: (n,) measured yaw at each pose, without leaps of a turn [rad].
    """

    name: str
    simulated: bool
    settings: Settings
    world: World
    path: RecordedPath
    yaws: np.ndarray


def fitted_run(run: RecordedRun) -> FittedRun:
    """Poses and commands of a recorded run.

    Raises:
        RunError: there are none, or their stamps do not rise.
    """
    run.check_poses()
    log = run.log
    poses = np.array([pose[:4] for pose in log.poses])
    falls = np.flatnonzero(np.diff(poses[:, 0]) <= 0.0)
    if len(falls):
        before, after = poses[falls[0] : falls[0] + 2, 0] - log.begin
        raise RunError(f"{run.folder}: got a pose at {after:g} s after one at {before:g} s, expected times that rise")
    commands = [log.command_at(pose.sent) for pose in log.poses]
    wanted = np.array([(each.vx, each.vy) if each else (0.0, 0.0) for each in commands])
    yaws = poses[:, 3]
    path = RecordedPath(poses[:, 0] - log.begin, poses[:, 1:3], rotate_rows(wanted, yaws))
    return FittedRun(str(run.folder), log.simulated, run.settings, run.world, path, np.unwrap(yaws))
