"""Largest acceleration, lag and delay of the drive, learnt from commands and poses while the robot drives.

A grid of drives is compared by how well a filter with each foresees every pose (`bank.py`). The sums of the logarithms
of the likelihoods are the posterior; they fade towards the prior while the robot drives, and none is ever far behind
the best, so that another floor or load is seen within seconds. Poses are used only while nothing but the wheels moves
the robot, and WAIT after they were measured: an impact is reported later than it was.
"""

import math
from collections import deque
from typing import NamedTuple

import numpy as np

from collplan_core.control.stuck import with_row
from collplan_core.learning.bank import (
    ROW,
    VV_XX,
    VV_YY,
    VX,
    VY,
    X_VX,
    XX,
    Y_VY,
    YY,
    ScoreLaw,
    X,
    Y,
    foresee,
    judge,
    learn,
    take,
)
from collplan_core.learning.drive import Drive, Learnt, LearntDrive

WAIT = 0.12
"""Poses are used so long after they were measured [s]."""
BEFORE, AFTER = 0.11, 0.05
"""Poses so near in time to an impact are left out [s]: its stamp is that of the pose that showed it."""
GAP = 0.055
"""A longer pause between two poses begins a new stretch [s]."""
FIRST, UNSCORED = 6, 2
"""Poses whose line gives the first velocity of a stretch, and means after them that move no score."""
MEAN_OF = 0.009
"""Poses are taken as their mean until they span so much [s]: two at 100 Hz. It halves the work."""
KEPT_COMMANDS = 1.0
"""[s]"""
OUTLIER, MOST, IN_A_ROW = 20.0, 6.0, 3
"""Square of the best model's innovation from which a pose is skipped; most by which one moves a score; and number
skipped in a row that ends the stretch."""
DEEPEST = 60.0
"""Most by which a score is behind the best: another floor is seen within seconds."""
FORGET, IDLE = 20.0, 1e-3
"""Driving time in which scores fade to 1/e [s]; poses that tell the models apart by less are no driving."""
NOISE_POSES = 150.0
"""Number of poses over which their noise is averaged."""
SPREADS = (0.45, 0.8, 0.03)
"""Standard deviations of the prior: of the logarithms of largest acceleration and lag, and of the delay [s]."""
WIDER = (1.8, 3.5, 2.0)
"""Factors on the deviations of the three: errors of the wheels last, and are not as the models take them."""
LEAST = (0.01, 0.02, 0.002)
"""Their smallest deviations."""
ACCELERATIONS, LAGS, DELAYS = (0.25, 3.0, 24), (0.25, 5.0, 12), (-0.03, 0.06, 4)
"""First and last node and their number: factors of the belief, and differences from it [s]."""
LEAST_LAG = 0.02
"""A shorter lag is no different [s]."""


class _Pose(NamedTuple):
    stamp: float
    x: float
    y: float
    yaw: float


class DriveLearner:
    """Takes commands and poses in the order of time, all times on the poses' clock [s].

    Attributes:
        skipped: number of poses that no model explained.
    """

    def __init__(self, belief: Drive, pose_noise: float) -> None:
        """Begins with what the parameters tell, and the deviation of a measured position by axis [m]."""
        self.belief = belief
        self._accelerations = belief.max_acceleration * np.geomspace(*ACCELERATIONS)
        self._lags = max(belief.lag, LEAST_LAG) * np.geomspace(*LAGS)
        low, high, n = DELAYS
        self._delays = max(belief.delay + low, 0.0) + np.linspace(0.0, high - low, n)
        self._nodes = np.log(self._accelerations), np.log(self._lags), self._delays
        grid = np.meshgrid(self._delays, self._nodes[0], self._nodes[1], indexing="ij")
        off = [grid[1] - math.log(belief.max_acceleration), grid[2] - math.log(max(belief.lag, LEAST_LAG))]
        off.append(grid[0] - belief.delay)
        far = [(each / spread) ** 2 for each, spread in zip(off, SPREADS, strict=True)]
        self._prior = -0.5 * (far[0] + far[1] + far[2]).ravel()
        self._scores = self._prior - self._prior.max()
        models = self._scores.size
        self._bank, self._told, self._best = np.zeros((models, ROW)), np.zeros(models), int(self._scores.argmax())
        self._law = ScoreLaw(ACCELERATIONS[2], LAGS[2], MOST, DEEPEST)
        self._commands = np.zeros((0, 3))
        self._waiting: deque[_Pose] = deque()
        self._first: list[_Pose] = []
        self._held: list[_Pose] = []
        self._recent: deque[_Pose] = deque(maxlen=4)
        self._at: float | None = None
        self._newest, self._blocked = -math.inf, -math.inf
        self._unscored = self._in_a_row = self.skipped = 0
        self._variance, self._misfit = pose_noise**2, 1.0

    # ---- inputs

    def take_command(self, velocity: np.ndarray, now: float) -> None:
        """Takes a velocity (2,) [m/s, body frame] that is sent now."""
        self._commands = with_row(self._commands, np.array([now, *velocity.tolist()]), KEPT_COMMANDS, 1)

    def take_pose(self, stamp: float, x: float, y: float, yaw: float) -> None:
        """Takes a pose."""
        if stamp >= self._blocked:
            self._waiting.append(_Pose(stamp, x, y, yaw))
        while self._waiting and self._waiting[0].stamp <= stamp - WAIT:
            self._use(self._waiting.popleft())

    def exclude(self, begin: float, end: float) -> None:
        """Leaves out what may have been moved by something other than its wheels from `begin` to `end` [s]."""
        self._waiting = deque(pose for pose in self._waiting if not begin <= pose.stamp < end)
        self._blocked = max(self._blocked, end)
        if begin <= self._newest:
            self._end_stretch()

    def take_impact(self, stamp: float) -> None:
        """Takes an impact."""
        self.exclude(stamp - BEFORE, stamp + AFTER)

    def begin_anew(self) -> None:
        """Takes a break in the poses or their clock; what was learnt stays."""
        self._waiting.clear()
        self._commands = np.zeros((0, 3))
        self._blocked = self._newest = -math.inf
        self._end_stretch()

    # ---- one pose

    def _use(self, pose: _Pose) -> None:
        self._measure_noise(pose)
        if pose.stamp - self._newest > GAP:
            self._end_stretch()
        self._newest = pose.stamp
        if self._at is None:
            self._first.append(pose)
            if len(self._first) == FIRST:
                self._begin_stretch()
            return
        self._held.append(pose)
        if pose.stamp - self._held[0].stamp >= MEAN_OF:
            n = len(self._held)
            stamp, x, y = (sum(column) / n for column in list(zip(*self._held, strict=True))[:3])
            self._held = []
            self._compare(_Pose(stamp, x, y, pose.yaw), self._variance / n)

    def _compare(self, pose: _Pose, variance: float) -> None:
        """Compares the models by a mean of poses, of that variance by axis [m^2]."""
        assert self._at is not None, "the stretch has begun"
        span, begin, self._at = pose.stamp - self._at, self._at, pose.stamp
        grid = self._delays, self._accelerations, self._lags
        foresee(self._bank, *grid, self._commands, begin, pose.stamp, pose.yaw)
        square, least = judge(self._bank, pose.x, pose.y, variance, self._told, self._best)
        if min(square, least + MOST) > OUTLIER:
            self.skipped += 1
            self._in_a_row += 1
            if self._in_a_row >= IN_A_ROW:
                self._end_stretch()
            return
        self._in_a_row = 0
        take(self._bank, pose.x, pose.y, variance)
        if self._unscored > 0:
            self._unscored -= 1
            return
        self._misfit += 0.02 * (0.5 * square - self._misfit)
        if np.ptp(self._told) > IDLE:
            kept = math.exp(-span / FORGET)
            self._best = learn(self._scores, self._prior, self._told, self._law, kept, self._misfit)

    def _measure_noise(self, pose: _Pose) -> None:
        """Third differences leave out a constant acceleration, and have 20 times the variance of a pose."""
        self._recent.append(pose)
        if len(self._recent) < 4:
            return
        a, b, c, d = self._recent
        gaps = b.stamp - a.stamp, c.stamp - b.stamp, d.stamp - c.stamp
        if max(gaps) - min(gaps) > 0.2 * min(gaps) or max(gaps) > 0.25 * GAP:
            return
        for third in (d.x - 3.0 * c.x + 3.0 * b.x - a.x, d.y - 3.0 * c.y + 3.0 * b.y - a.y):
            square = min(third * third / 20.0, 9.0 * self._variance)
            self._variance += (square - self._variance) / (2.0 * NOISE_POSES)

    # ---- stretches

    def _end_stretch(self) -> None:
        self._at, self._first, self._held, self._in_a_row = None, [], [], 0

    def _begin_stretch(self) -> None:
        """Begins at the end of a line through the first poses."""
        rows = np.array([pose[:3] for pose in self._first])
        since = rows[:, 0] - rows[:, 0].mean()
        spread, late = float((since**2).sum()), float(since[-1])
        velocity = since @ rows[:, 1:] / spread
        bank, variance = self._bank, self._variance
        bank[:] = 0.0
        bank[:, [X, Y]], bank[:, [VX, VY]] = rows[:, 1:].mean(axis=0) + late * velocity, velocity
        bank[:, [XX, YY]] = variance * (1.0 / FIRST + late**2 / spread) + 1e-6
        bank[:, [X_VX, Y_VY]] = variance * late / spread
        unknown = 0.5 * (np.repeat(self._accelerations, len(self._lags)) * late) ** 2
        bank[:, VV_XX] = bank[:, VV_YY] = variance / spread + np.tile(unknown, len(self._delays))
        self._at, self._first, self._unscored = float(rows[-1, 0]), [], UNSCORED

    # ---- results

    @property
    def learnt(self) -> LearntDrive:
        """What the poses so far tell."""
        chances = np.exp(self._scores).reshape(DELAYS[2], ACCELERATIONS[2], LAGS[2])
        found = []
        for k, (axis, nodes) in enumerate(zip((1, 2, 0), self._nodes, strict=True)):
            others = tuple(other for other in range(3) if other != axis)
            middle, deviation = _peak(nodes, chances.sum(axis=others))
            found.append(Learnt(middle, max(deviation, LEAST[k]) * WIDER[k], is_log=k < 2))
        return LearntDrive(*found)


def warm_up() -> None:
    """Compiles the filters, so that no pose has to wait for them."""
    learner = DriveLearner(Drive(1.0, 0.1, 0.0), 0.001)
    for k in range(30):
        learner.take_command(np.array([0.1, 0.0]), 0.01 * k)
        learner.take_pose(0.01 * k, 0.0, 0.0, 0.0)


def _peak(nodes: np.ndarray, chances: np.ndarray) -> tuple[float, float]:
    """Median and deviation: of a parabola through the likeliest node and its neighbours, if that is narrow enough."""
    k, step = int(chances.argmax()), float(nodes[1] - nodes[0])
    if 0 < k < len(nodes) - 1:
        low, top, high = np.log(chances[k - 1 : k + 2] + 1e-300).tolist()
        bend = 2.0 * top - low - high
        if bend >= 1.0:
            shift = min(max(0.5 * (high - low) / bend, -0.5), 0.5)
            return float(nodes[k]) + step * shift, step / math.sqrt(bend)
    shares = chances / chances.sum()
    middle = float(shares @ nodes)
    return middle, math.sqrt(float(shares @ (nodes - middle) ** 2) + step**2 / 12.0)
