"""Commanded against measured motion: the whole delay between them, and whether the robot follows its commands at all.

Commands and measured velocities of the last WINDOW are compared under many ways in which the second may follow from the
first (`poses/motion_fit.py`): the misfit of a way is the integral of the squared error of the velocity
[m^2/s]. The mass is free in each window, at a price: a robot that is heavier than robot.mass, or whose wheels are weak
for a while, lags too and is not late. Delays pay for what they explained badly before, each measurement counted about
once. A verdict needs an advantage over all other explanations. What a wall does is left out: judging begins anew SETTLE
after the last pose near one, and UNSEEN after a hit that no wall seen explains or after the robot was stuck. A robot
that only slows or stands moves against no command, whatever makes it stand.

Where poses carry the time at which they were measured, a delay that grows shows without motion, in receipt less stamp.
Commands must come at 4 Hz or more.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from collplan_core.control import stuck
from collplan_core.control.drive_record import BY_RECEIPT, DriveRecord
from collplan_core.jit import njit
from collplan_core.parameters import Settings
from collplan_core.poses.motion_fit import DELAYS, MASSES, STEP, misfits, ways
from collplan_core.velocity_law import velocity_law

OK, LATE, STUCK, SLIP, REVERSED = "ok", "late", "stuck", "slip", "reversed"
STOPPING = (LATE, REVERSED)
"""Kinds of verdict at which the controller stops."""

WINDOW = 0.6
"""[s]"""
SHORTEST_WINDOW = 0.15
"""[s]"""
SETTLE = 0.2
"""Time after a touch until wheels that it did not stop roll again, and until a command that reverses at it has come
through the robot's cap of acceleration: 0.18 s at 10 m/s^2 [s]."""
UNSEEN = 1.0
"""Time for which something that was run into and is not seen may push on [s]."""
LATE_ADVANTAGE = 1.5e-3
"""Advantage of the delays beyond the limit from which motion is late [m^2/s], where the comparison before pointed that
way too.

With it a delay of 0.2 s is named within 0.3 s, in 12 simulated starts, with 2.5e-3 within 0.45 s. Single comparisons,
between others far on the other side, gave 1.9e-3 of a robot of twice the believed mass that was in time.
"""
LATE_ANYHOW = 0.75e-3
"""So much of that advantage must be left where the velocity at the begin of the window is uncertain [m^2/s]: one that
begins in the middle of a start, with a reading too fast, looks late otherwise."""
LATE_MISFIT = 2.5e-3
"""Motion that no delay explains better than this is not late [m^2/s], nor better than FOLLOWS times the best in time:
simulated, late motion leaves 1.5e-3 when it is named, and a robot that rubs along a wall it does not see 5.7e-3."""
FOLLOWS = 0.25
"""One whose delay is longer than LONGEST_DELAY is explained badly, and much worse by those in time."""
WRONG_ADVANTAGE = 6e-3
"""Advantage of turned commands, or of wheels without force, from which motion is reversed or slips [m^2/s]."""
TURN_TIME = 0.2
"""Motion is reversed only where the robot gained speed against its commands in a part of the window so long [s]."""
GAINED = 0.1
"""Speed that it must have gained [m/s]: one that brakes or stands gains none, whatever does not fit its commands."""
CLEAR = 1.5e-3
"""Advantage of a delay over those that differ by 0.1 s from which it is published [m^2/s]."""
FOLLOWING = 0.5e-3
"""Advantage over wheels without force from which motion teaches anything [m^2/s]."""
FORCELESS = 1e-3
"""Initial price of wheels without force [m^2/s]."""
HEAVY = np.array([0.0, 0.0, 1e-3, 2e-3, 2e-3])
"""Price of each of MASSES, added to its misfit [m^2/s]."""
LEARNT = 0.1
"""Share of the misfit of each window that a delay pays from then on: 12 windows hold the same measurement."""
MOST_LEARNT = 0.014
"""Most that it pays, so that a change is seen [m^2/s]: 0.2 s that come while the robot drives within 1.8 s, 0.3 s in
1.4 s, in 8 simulated drives."""
SMOOTHED = 0.2
"""Weight of a new estimate of the delay against the earlier ones."""
SLOW_STAMPS = 0.97
"""Stamps that advance less than this in a second are of a slow clock, where no single pose came late."""
SINGLE = 0.5
"""Share of what poses came later by, more than which a slow clock does not add between two of them."""
GROWTH_TIME = 0.25
"""Time for which poses must come later than they did [s]."""
DRIFT = 0.002
"""Rate at which the smallest delay seen is forgotten, as two clocks may drift apart [s/s]."""
_OWN_STALL = 0.3
_OVERDUE = 2.5
"""Periods of control after which the last command may have left later than is known: the controller stalled."""
_OFTEN = 5


@dataclass(frozen=True)
class MotionVerdict:
    """Verdict on how the robot moves, compared with its commands."""

    kind: str = OK  # OK, LATE, STUCK (commanded and not moving), SLIP (moves, and not by the commands) or REVERSED
    delay: float = math.nan  # newest estimate of the delay from command to measured motion [s]; NaN before the first
    reason: str = ""  # explanation of the verdict; empty where it is OK


class MotionRecord(NamedTuple):
    """Commands and motion since something else began to move the robot, and what they have shown; local clock."""

    drive: DriveRecord = DriveRecord()
    free_since: float = -math.inf  # time since which only the wheels have moved the robot [s]
    quickest: float = math.inf  # smallest difference of receipt and stamp seen, drift added [s]
    learnt: np.ndarray = np.zeros(len(DELAYS))  # (k,) price of each of DELAYS [m^2/s]
    delay: float = math.nan  # newest estimate of the delay [s]; NaN before the first
    advantage: float = 0.0
    """Advantage of the delays beyond the limit over all others, where last compared [m^2/s]; 0 without that."""

    @property
    def motion(self) -> np.ndarray:
        """(m, 7) as in the record of the drive."""
        return self.drive.motion

    @property
    def commands(self) -> np.ndarray:
        """(n, 3) time [s] and velocity [m/s, world frame]."""
        return self.drive.told(BY_RECEIPT)


def restart(record: MotionRecord) -> MotionRecord:
    """The record after a break in the poses: it keeps what was learnt, and drops the motion."""
    return MotionRecord(record.drive.forgotten(), learnt=record.learnt, delay=record.delay)


def add_pose(record: MotionRecord, drive: DriveRecord, touching: bool) -> MotionRecord:
    """The record with the newest pose of `drive`; `touching` where a wall is within reach of the ring."""
    local, stamp = drive.motion[-1, :2].tolist()
    since = local - float(record.motion[-1, 0]) if len(record.motion) else 0.0
    quickest = min(record.quickest + DRIFT * since, local - stamp)
    free_since = max(record.free_since, local + SETTLE) if touching else record.free_since
    return record._replace(drive=drive.since(record.drive), free_since=free_since, quickest=quickest)


def ignore_until(record: MotionRecord, until: float) -> MotionRecord:
    """The record of a robot that something other than its wheels may move until a time [s]."""
    return record._replace(free_since=max(record.free_since, until))


def add_command(record: MotionRecord, drive: DriveRecord) -> MotionRecord:
    """The record with the newest command of `drive`."""
    sent = record.drive.commands[-1:, 0]
    if len(sent) and drive.commands[-1, 0] - sent[0] > _OWN_STALL:
        record = restart(record)
    return record._replace(drive=drive.since(record.drive))


def judge_motion(record: MotionRecord, now: float, settings: Settings) -> tuple[MotionVerdict, MotionRecord]:
    """The verdict at `now` [s], and the record with what was learnt; uses settings.robot, .limits and .mocap."""
    commands, motion = record.commands, record.motion
    if not commands[:, 1:].any() or len(motion) < 3:
        return MotionVerdict(OK, record.delay), record
    if now - commands[-1, 0] > _OVERDUE / settings.controller.rate:
        record = ignore_until(record, now)
    limit = settings.limits.motion_delay
    growth = _growth(motion, record.quickest, now)
    if growth > limit:
        return _late(record, growth, limit, "poses come later than they did, by"), record
    why_stuck = stuck.why_stuck(motion[:, [0, 4, 5]], commands, settings.robot.max_acceleration)
    if why_stuck:
        # what holds it unseen may push it aside as well
        return MotionVerdict(STUCK, record.delay, why_stuck), ignore_until(record, now + UNSEEN)
    begin, velocities = _window(motion, record.free_since, settings.mocap.velocity_window, now)
    if len(velocities) == 0:
        return MotionVerdict(OK, record.delay), record._replace(advantage=0.0)
    return _compared(record, begin, velocities, settings)


def _late(record: MotionRecord, delay: float, limit: float, what: str) -> MotionVerdict:
    pace = _pace(record)
    if pace < SLOW_STAMPS:
        slow = f"stamps of the poses advance by {pace:.2f} s in a second"
        return MotionVerdict(LATE, delay, f"{slow}: a simulation? then use_sim_time: true for every node")
    return MotionVerdict(LATE, delay, f"{what} {delay:.2f} s, limit {limit:.2f} s")


def _pace(record: MotionRecord) -> float:
    """Returns how much the stamps advance in a second since the quickest pose kept; 1 where single poses came late."""
    motion = record.motion
    delays = motion[:, 0] - motion[:, 1]
    since = int(delays.argmin())
    grown, passed = delays[-1] - delays[since], motion[-1, 0] - motion[since, 0]
    if passed < 0.6 * GROWTH_TIME or np.diff(delays[since:]).max() > SINGLE * grown:
        return 1.0
    return float((motion[-1, 1] - motion[since, 1]) / passed)


@njit
def _growth(motion: np.ndarray, quickest: float, now: float) -> float:
    """Returns how much later than the quickest all poses of the last GROWTH_TIME came [s]; 0 for too few poses."""
    n, first, least = len(motion), len(motion), math.inf
    while first > 0 and motion[first - 1, 0] > now - GROWTH_TIME:
        first -= 1
        least = min(least, motion[first, 0] - motion[first, 1])
    # messages that waited in a queue arrive all at once
    if n - first < _OFTEN or motion[n - 1, 0] - motion[first, 0] < 0.6 * GROWTH_TIME:
        return 0.0
    return least - quickest


@njit
def _window(motion: np.ndarray, free_since: float, velocity_window: float, now: float) -> tuple[float, np.ndarray]:
    """Begin [s] and measured velocities (n, 2), STEP apart; none where too little can be judged."""
    offset = (motion[:, 0] - motion[:, 1]).min()
    times = motion[:, 1] + offset - 0.5 * velocity_window
    end = times[-1]
    n = int((end - max(end - WINDOW, free_since, times[0])) / STEP + 1e-6) + 1
    if (n - 1) * STEP < SHORTEST_WINDOW or now - end > 0.2:
        return end, np.zeros((0, 2))
    begin, last = end - (n - 1) * STEP, len(times) - 1
    velocities, i = np.empty((n, 2)), 0
    for k in range(n):
        time = begin + k * STEP
        while i < last and times[i + 1] <= time:
            i += 1
        for c in range(2):
            before = motion[i, 2 + c]
            velocities[k, c] = before
            if i < last and time > times[i]:
                slope = (motion[i + 1, 2 + c] - before) / (times[i + 1] - times[i])
                velocities[k, c] = slope * (time - times[i]) + before
    return begin, velocities


def _compared(
    record: MotionRecord, begin: float, velocities: np.ndarray, settings: Settings
) -> tuple[MotionVerdict, MotionRecord]:
    """The verdict of one window, and the record updated by it."""
    law, limit = velocity_law(settings.robot), settings.limits.motion_delay
    all_ways = ways(float(record.motion[-1, 6]))
    fits = misfits(record.commands, velocities, begin, all_ways.rows, law.max_acceleration, law.lag)
    costs, uncertain = fits[:, 0], fits[: all_ways.n_plain, 1].reshape(len(DELAYS), len(MASSES)) + HEAVY
    plain = costs[: all_ways.n_plain].reshape(len(DELAYS), len(MASSES))
    dead = float(costs[all_ways.n_plain : all_ways.n_plain + all_ways.n_dead].min())
    turned = float(costs[all_ways.n_plain + all_ways.n_dead :].min())
    now = (plain + HEAVY).min(axis=1)
    if plain.min() <= dead - FOLLOWING:
        record = _update_delay_costs(record, now)
    by_delay = now + record.learnt
    # DELAYS rise: slices, which cost a fifth of masks
    in_time = slice(int(DELAYS.searchsorted(limit + 1e-9, side="right")))
    too_late = slice(int(DELAYS.searchsorted(limit + 1.2 * STEP, side="right")), None)
    normal = min(float(by_delay[in_time].min()), dead + FORCELESS)
    follows = float(plain[too_late].min()) < max(LATE_MISFIT, FOLLOWS * float(now[in_time].min()))
    is_clear = float(uncertain[in_time].min() - uncertain[too_late].min()) > LATE_ANYHOW
    before, advantage = record.advantage, normal - float(by_delay[too_late].min())
    record = record._replace(advantage=advantage)
    if follows and is_clear and before > 0.0 and advantage > LATE_ADVANTAGE:
        measured = float(DELAYS[too_late][int(by_delay[too_late].argmin())])
        return _late(record, measured, limit, "motion comes after its command by"), record
    is_worse = min(float(plain.min()), dead) - turned > WRONG_ADVANTAGE
    if is_worse and _drives_against(record.commands, velocities, begin, limit):
        return MotionVerdict(REVERSED, record.delay, "motion is turned or mirrored against the commands"), record
    if float(plain[in_time].min()) - dead > WRONG_ADVANTAGE:
        return MotionVerdict(SLIP, record.delay, "motion does not follow the commands: the wheels lack force"), record
    return MotionVerdict(OK, record.delay), record


def _drives_against(commands: np.ndarray, velocities: np.ndarray, begin: float, delay: float) -> bool:
    """True where the robot gained speed in any TURN_TIME, but not towards its commands of up to `delay` [s] before."""
    # means of three: a single velocity has noise
    smooth = (velocities[:-2] + velocities[1:-1] + velocities[2:]) / 3.0
    n = round(TURN_TIME / STEP) - 2
    gained = np.hypot(*smooth[n:].T) - np.hypot(*smooth[:-n].T)
    for k in np.flatnonzero(gained > GAINED):
        end = begin + k * STEP + TURN_TIME
        told = commands[(commands[:, 0] > end - TURN_TIME - delay) & (commands[:, 0] <= end), 1:]
        if len(told) and (told.mean(axis=0) - smooth[k]) @ (smooth[k + n] - smooth[k]) <= 0.0:
            return True
    return False


def _update_delay_costs(record: MotionRecord, misfit: np.ndarray) -> MotionRecord:
    """The record updated by one window's misfit of each of DELAYS (k,) [m^2/s]."""
    learnt = record.learnt + LEARNT * misfit
    learnt = np.minimum(learnt - learnt.min(), MOST_LEARNT)
    by_delay = misfit + learnt
    best = int(by_delay.argmin())
    delay = record.delay
    if by_delay[abs(DELAYS - DELAYS[best]) >= 0.1].min() - by_delay[best] > CLEAR:
        delay = float(DELAYS[best]) if math.isnan(delay) else delay + SMOOTHED * (float(DELAYS[best]) - delay)
    return record._replace(learnt=learnt, delay=delay)
