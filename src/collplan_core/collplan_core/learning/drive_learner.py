"""Largest acceleration, lag and delay of the drive, learnt from commands and poses while the robot drives.

A grid of drives is compared by how well a filter with each foresees every pose (`bank.py`). Poses are used only while
nothing but the wheels moves the robot, and WAIT after they were measured: an impact is reported later than it was.
"""

import math
from collections import deque
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.learning.bank import Bank, compare, learn
from collplan_core.learning.drive import Drive, Learnt, LearntDrive

WAIT, BEFORE, AFTER = 0.12, 0.11, 0.05
"""Poses are used so long after they were measured, and not so near to an impact, which is stamped late [s]."""
GAP, GAPS, FIRST, UNSCORED = 0.055, 3.0, 6, 2
"""Pause after which a new stretch begins [s], or in mean intervals where poses come seldom, up to WAIT; poses whose
line gives its first velocity, and means without a score."""
MEAN_OF = 0.009
"""Poses are taken as their mean until they span so much [s]: two at 100 Hz. It halves the work."""
OUTLIER, IN_A_ROW, MOST = 20.0, 3, 6.0
"""Square of the best model's error at which a pose is skipped, number in a row that end the stretch, most that one
moves a score."""
DEEPEST, FORGET, IDLE = 60.0, 20.0, 1e-3
"""Most by which a score is behind, so that another floor is seen within seconds; driving time in which scores fade to
1/e [s]; poses that tell the models apart by less are no driving."""
BEHIND, ROUSED = 25.0, 1.25
"""Score behind the best at which a model sleeps, and the misfit from which on all are awake: the drive has changed, or
none is right."""
NOISE_POSES, INTERVALS, MISFIT_POSES = 150.0, 20.0, 50.0
"""Poses over which their noise is averaged, and their interval, and means of them over which the misfit is."""
SPREADS = (0.45, 0.8, 0.03)
"""Standard deviations of the prior: of the logarithms of largest acceleration and lag, and of the delay [s]."""
WIDER, LEAST = (1.8, 3.5, 2.0), (0.01, 0.02, 0.002)
"""Factors on the deviations of the three, as errors of the wheels last; and what these are at least before that."""
DOUBT = 1.5
"""Factor on the deviations where the belief is left for what was learnt. Waiting until the wide interval is narrow
would cost more than the error of the median, which the belief already draws to itself."""
ACCELERATIONS, LAGS, DELAYS = (0.25, 3.0, 24), (0.25, 5.0, 12), (0.0, 0.09, 4)
"""First and last node and their number: factors of the belief, and delays after the earliest that may be [s]."""
INTERVAL = 1.645
"""Half the width of an interval that holds nine of ten, in standard deviations."""
LEAST_LAG, KEPT = 0.02, 1.0
"""A shorter lag is no different; commands that are older than the newest by more are not looked at [s]."""


class _Pose(NamedTuple):
    stamp: float
    x: float
    y: float
    yaw: float


class DriveLearner:
    """Takes poses in the order of time, and the commands so far, all times on the poses' clock [s]."""

    def __init__(self, belief: Drive, pose_noise: float) -> None:
        """Begins with what the parameters tell, and the deviation of a measured position by axis [m]."""
        # belief: the drive that the parameters tell; driven: time of driving that told drives apart [s]
        self.belief, self.driven = belief, 0.0
        at = math.log(belief.max_acceleration), math.log(max(belief.lag, LEAST_LAG)), belief.delay
        self._nodes = (
            at[0] + np.log(np.geomspace(*ACCELERATIONS)),
            at[1] + np.log(np.geomspace(*LAGS)),
            max(belief.delay - SPREADS[2], 0.0) + np.linspace(*DELAYS),
        )
        off = [((nodes - middle) / spread) ** 2 for nodes, middle, spread in zip(self._nodes, at, SPREADS, strict=True)]
        prior = -0.5 * (off[2][:, None, None] + off[0][:, None] + off[1])
        self._shape, n, prior = prior.shape, prior.size, prior.ravel() - prior.max()
        axes = self._nodes[2], np.exp(self._nodes[0]), np.exp(self._nodes[1])
        states = np.zeros((n, 4)), np.zeros((n, 4, 4))
        self._bank = Bank(*axes, *states, prior.copy(), prior, np.zeros(n), np.ones(n, bool))
        self._best = int(prior.argmax())
        self._told = np.zeros((0, 3))
        self._waiting: deque[_Pose] = deque()
        self._recent: deque[_Pose] = deque(maxlen=4)
        self._newest, self._blocked = -math.inf, -math.inf
        self._variance, self._misfit, self._interval = pose_noise**2, 1.0, 0.0
        self._end_stretch()

    def take_pose(self, pose: tuple[float, float, float, float], commands: np.ndarray) -> None:
        """Takes a pose: its stamp [s], x, y [m] and yaw [rad]; commands (n, 3), as in `bank.foresee`."""
        self._told = commands
        if pose[0] >= self._blocked:
            self._waiting.append(_Pose(*pose))
        while self._waiting and self._waiting[0].stamp <= pose[0] - WAIT:
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
        self._blocked = self._newest = -math.inf
        self._end_stretch()

    def _end_stretch(self) -> None:
        self._at: float | None = None
        self._held: list[_Pose] = []
        self._in_a_row, self._unscored = 0, UNSCORED

    def _use(self, pose: _Pose) -> None:
        self._measure_noise(pose)
        since = pose.stamp - self._newest
        if since > max(GAP, min(GAPS * self._interval, WAIT)):
            self._end_stretch()
        if since < WAIT:
            self._interval += (since - self._interval) / INTERVALS
        self._newest = pose.stamp
        self._held.append(pose)
        if self._at is None:
            if len(self._held) == FIRST:
                self._begin_stretch(np.array(self._held)[:, :3])
        elif pose.stamp - self._held[0].stamp >= MEAN_OF:
            n, held, self._held = len(self._held), self._held, []
            stamp, x, y = (sum(each[k] for each in held) / n for k in range(3))
            self._compare(_Pose(stamp, x, y, pose.yaw), self._at, self._variance / n)

    def _compare(self, pose: _Pose, begin: float, variance: float) -> None:
        """Compares the models, from `begin` on [s], by a mean of poses, of that variance by axis [m^2]."""
        self._at = pose.stamp
        bank, limits = tuple(self._bank), (OUTLIER, MOST)
        told = self._told
        told = told[max(int(told[:, 0].searchsorted(told[-1:, 0].sum() - KEPT)) - 1, 0) :]
        square, apart, is_outlier = compare(bank, told, begin, tuple(pose), variance, self._best, limits)
        if is_outlier:
            self._in_a_row += 1
            if self._in_a_row >= IN_A_ROW:
                self._end_stretch()
            return
        self._in_a_row, self._unscored = 0, self._unscored - 1
        if self._unscored >= 0:
            return
        self._misfit += (0.5 * square - self._misfit) / MISFIT_POSES
        if apart > IDLE:
            self.driven += pose.stamp - begin
            kept = math.exp((begin - pose.stamp) / FORGET)
            behind = BEHIND if self._misfit < ROUSED else math.inf
            self._best = learn(bank, kept, 1.0 / max(1.0, self._misfit), MOST, DEEPEST, behind)

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

    def _begin_stretch(self, rows: np.ndarray) -> None:
        """Begins at the end of a line through the first poses (n, 3): stamp and position."""
        since = rows[:, 0] - rows[:, 0].mean()
        spread, late = float((since**2).sum()), float(since[-1])
        velocity = since @ rows[:, 1:] / spread
        unknown = np.tile(np.repeat(0.5 * (self._bank.accelerations * late) ** 2, self._shape[2]), self._shape[0])
        means, p, variance = self._bank.means, self._bank.covariances, self._variance
        means[:, :2], means[:, 2:] = rows[:, 1:].mean(axis=0) + late * velocity, velocity
        p[:] = 0.0
        for c in range(2):
            p[:, c, c] = variance * (1.0 / FIRST + late**2 / spread) + 1e-6
            p[:, c, 2 + c] = p[:, 2 + c, c] = variance * late / spread
            p[:, 2 + c, 2 + c] = variance / spread + unknown
        self._at, self._held = float(rows[-1, 0]), []

    @property
    def learnt(self) -> LearntDrive:
        """Drive that the poses so far show, with intervals."""
        chances = np.exp(self._bank.scores).reshape(self._shape)
        found = []
        for k, (nodes, others) in enumerate(zip(self._nodes, ((0, 2), (0, 1), (1, 2)), strict=True)):
            middle, deviation = _peak(nodes, chances.sum(axis=others))
            wide = max(deviation, LEAST[k]) * WIDER[k]
            known = max(0.0, 1.0 - (DOUBT * deviation / SPREADS[k]) ** 2)
            ends = middle, middle - INTERVAL * wide, middle + INTERVAL * wide
            value, low, high = (math.exp(end) if k < 2 else max(end, 0.0) for end in ends)
            found.append(Learnt(value, low, high, known))
        return LearntDrive(*found)


@njit
def _peak(nodes: np.ndarray, chances: np.ndarray) -> tuple[float, float]:
    """Median and deviation: of a parabola through the likeliest node and its neighbours, if that is narrow enough."""
    k, step = chances.argmax(), nodes[1] - nodes[0]
    if 0 < k < len(nodes) - 1:
        low, top, high = np.log(chances[k - 1 : k + 2] + 1e-300)
        bend = 2.0 * top - low - high
        if bend >= 1.0:
            shift = min(max(0.5 * (high - low) / bend, -0.5), 0.5)
            return nodes[k] + step * shift, step / math.sqrt(bend)
    shares = chances / chances.sum()
    middle = (shares * nodes).sum()
    return middle, math.sqrt((shares * (nodes - middle) ** 2).sum() + step**2 / 12.0)


def warm_up() -> None:
    """Compiles the filters, so that no pose has to wait for them."""
    learner = DriveLearner(Drive(1.0, 0.1, 0.0), 0.001)
    for k in range(30):
        learner.take_pose((0.01 * k, 0.0, 0.0, 0.0), np.array([[0.0, 0.1, 0.0]]))
    _ = learner.learnt
