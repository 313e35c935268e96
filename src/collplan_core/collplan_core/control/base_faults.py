"""Names a base that follows other commands than it is given: by a limit, a scale, or along x alone.

A fault is a change of the commands. Motion of the last KEPT windows is fitted to the commands of each, as in
`motion_monitor.py`, for many delays and masses. A fault counts where it explains more than the right base does.
"""

from collections import deque
from collections.abc import Iterator

import numpy as np

from collplan_core.control.drive_record import OF_BODY, DriveRecord
from collplan_core.parameters import Robot
from collplan_core.plane import rotate
from collplan_core.poses.motion_fit import STEP, misfits
from collplan_core.velocity_law import velocity_law

WINDOW, PERIOD, KEPT = 0.6, 0.3, 24
"""Time compared at once, from one such window to the next [s], and number of windows looked at together."""
TURNED = 0.3
"""Windows in which the robot turns more than this are left out [rad]."""
DELAYS, MASSES = (0.03, 0.08, 0.13, 0.23, 0.33), (0.6, 0.8, 1.0, 1.4, 2.0, 2.8, 4.0)
"""Delays, with half the time over which velocities are measured [s], and masses over robot.mass, of right bases."""
LAGS = (0.4, 1.0, 2.0, 4.0)
"""Lags over robot.velocity_lag of them."""
MOST, SURE, AWAY = 6e-3, 8e-3, 4e-3
"""Most that a window counts, which is also the misfit of one that no base explains; advantage over the right base from
which a fault is named, and over one that stands [m^2/s]. Right ones gave up to 1.2e-3 in 33 simulated drives."""
DRIFTS = 0.05 * np.array([(x, y) for x in (0, 1, -1) for y in (0, 1, -1)])
"""Velocities by which wheels that are not quite even drive beside their commands (9, 2) [m/s]."""

_ROWS = np.array([(delay, mass, 1.0, 0.0, 0.0, 1.0) for delay in DELAYS for mass in MASSES])


def _followed(told: np.ndarray, fastest: float) -> Iterator[tuple[str, np.ndarray]]:
    """Sentences on bases, and the commands (n, 2) [m/s] that each follows; the right ones reach `fastest` [m/s]."""
    # First is one that stands, then right ones, with DRIFTS, and what `motion_monitor.py` names.
    speeds = np.hypot(*told.T)[:, None]
    yield "", 0.0 * told
    yield from (("", told + drift * (speeds > 0.0)) for drift in DRIFTS)
    yield from (("", told * mirrored) for mirrored in ((1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)))
    yield "moves along x alone: can the base drive sideways?", told * (1.0, 0.0)
    for limit in np.array([0.3, 0.4, 0.5, 0.6, 0.7, 0.8]) * fastest:
        yield "never faster than {:.2f} of {:.2f} m/s commanded: another limit?", told * (limit / speeds.clip(limit))
    for share in (0.8, 0.9, 1.1, 1.25):
        yield f"moves {share:g} m for each metre commanded: do poses or wheels count right?", share * told
    for least in (0.1, 0.2, 0.3):
        yield f"stands at commands below {least:g} m/s: does the base ignore them?", told * (speeds >= least)


class BaseFaults:
    """Looks at commands and poses as they come, all times on the poses' clock [s]."""

    def __init__(self, robot: Robot) -> None:
        """Starts without any, for a robot as its parameters tell."""
        self._law, self._fastest = velocity_law(robot), robot.max_speed
        self._free = DriveRecord()  # since nothing but the wheels has moved the robot
        self._windows = deque[tuple[np.ndarray, float, float]](maxlen=KEPT)
        """Misfits (bases, ways) [m^2/s], and largest speeds measured and told [m/s]."""
        self._sentences: tuple[str, ...] = ()
        self._next = -np.inf

    def take_pose(self, drive: DriveRecord, free: bool) -> None:
        """Takes a pose; `free` where nothing but the wheels moves the robot, and it joins the one before."""
        if not free:
            self._free, self._next = drive.forgotten(), -np.inf
            return
        self._free = drive.since(self._free)
        motion = self._free.motion
        stamp = float(motion[-1, 1])
        if stamp < self._next or len(drive.commands) == 0:
            return
        sent, begin = drive.commands[:, 1], stamp - WINDOW
        if motion[0, 1] > begin or sent[0] > begin:
            return
        motion = motion[max(int(motion[:, 1].searchsorted(begin)) - 1, 0) :]
        if np.ptp(motion[:, 6]) < TURNED:
            self._next = motion[-1, 1] + PERIOD
            first = int(sent.searchsorted(sent[-1] - WINDOW - DELAYS[-1])) - 1
            self._judge(begin, drive.told(OF_BODY)[max(first, 0) :], motion)

    def _judge(self, begin: float, as_sent: np.ndarray, motion: np.ndarray) -> None:
        """Takes the window from `begin` [s] on: commands (n, 3) as sent, and the motion."""
        sent, told = as_sent[:, :1], as_sent[:, 1:]
        if not told.any():
            return
        times = begin + STEP * np.arange(round(WINDOW / STEP) + 1)
        velocities = np.array([rotate(vx, vy, -yaw) for vx, vy, _, _, yaw in motion[:, 2:].tolist()])
        moved = np.column_stack([np.interp(times, motion[:, 1], along) for along in velocities.T])
        self._sentences, followed = zip(*_followed(told, self._fastest), strict=True)
        # where all commands are slow, or fast, some bases follow them alike
        commands = {each.tobytes(): np.hstack([sent, each]) for each in followed}
        lags, acceleration = [share * self._law.lag for share in LAGS], self._law.max_acceleration
        ways = {
            key: np.concatenate([misfits(each, moved, begin, _ROWS, acceleration, lag)[:, 0] for lag in lags])
            for key, each in commands.items()
        }
        fits = np.array([ways[each.tobytes()] for each in followed])
        # noise of single velocities would be taken for speed
        speed = float(np.hypot(*moved[-5:].mean(axis=0)))
        if fits.min() < MOST:  # else something else moves it, or commands are turned
            self._windows.append((np.minimum(fits, fits.min() + MOST), speed, float(np.hypot(*told.T).max())))

    @property
    def why_unlike(self) -> str:
        """Sentence on the fault that explains the motion; "" where the right base does, or too little is known."""
        if not self._windows:
            return ""
        fits, speeds, told = zip(*self._windows, strict=True)
        stands, *found = np.sum(fits, axis=0).min(axis=1).tolist()
        least, right = min(found), min(found[: self._sentences.count("") - 1])
        if right - least < SURE or stands - least < AWAY:
            return ""
        return self._sentences[1 + found.index(least)].format(max(speeds), max(told))
