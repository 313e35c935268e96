"""No command drives the robot into what moves, as far as braking can prevent it; and nothing else is held."""

import math

import numpy as np
import pytest

from collplan_core.jit import njit
from collplan_core.movers.guard import IN_HAND, SLOWEST, STEP, body_of, is_approached, largest_share, own_speeds
from collplan_core.parameters import Settings
from collplan_core.velocity_law import velocity_after_step

SETTINGS = Settings()
BODY = body_of(SETTINGS)
NOWHERE = np.zeros((0, 4))
CLEARANCE, GROWTH = SETTINGS.movers.clearance, SETTINGS.movers.growth
REST, ALONG_X = np.zeros(4), np.array([1.2, 0.0])
DRIVES = np.array([0.0, 0.0, 1.2, 0.0])
SCENES = 100_000


def disc(x, y=0.0, vx=0.0, vy=0.0, radius=0.12, growth=GROWTH):
    return [x, y, x, y, vx, vy, radius + CLEARANCE, growth, 0.0, IN_HAND]


def share(rows, motion=REST, command=ALONG_X, walls=NOWHERE, least=0.0):
    rows = np.array(rows, dtype=float).reshape(-1, 10)
    return largest_share(rows, walls, BODY, np.asarray(motion, float), np.asarray(command, float), least)


@njit
def a_scene(random):
    """Movers and edges, walls, motion and command; distances at which they matter, half of them right in the way."""
    angle, speed, wanted = random.uniform(-np.pi, np.pi), random.uniform(0.0, 1.3), random.uniform(0.0, 1.2)
    turned = angle + random.uniform(-1.0, 1.0) * random.uniform(0.0, np.pi)
    motion = np.array([0.0, 0.0, speed * math.cos(angle), speed * math.sin(angle)])
    command = np.array([wanted * math.cos(turned), wanted * math.sin(turned)])
    rows = np.zeros((random.integers(1, 5), 10))
    for row in rows:
        bearing, far = turned + random.uniform(-1.0, 1.0) * random.uniform(0.0, np.pi), random.uniform(0.0, 1.5)
        row[0], row[1] = far * math.cos(bearing), far * math.sin(bearing)
        row[2], row[3] = row[0], row[1]
        if random.random() < 0.3:
            row[2] += random.uniform(-1.0, 1.0)
            row[3] += random.uniform(-1.0, 1.0)
            row[7], row[8] = random.uniform(0.0, 1.0), 0.1
        else:
            row[4], row[5], row[6] = random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(0.05, 0.25)
            row[7], row[8], row[9] = random.uniform(0.0, 0.5), max(0.0, random.uniform(-0.3, 0.3)), 0.05
    walls = random.uniform(-1.2, 1.2, (random.integers(0, 4), 4))
    return rows, walls, motion, command


@njit
def odd_scenes(random, scenes, body):
    """Numbers of scenes in which a command was sent that it should not have been, and in which one was held."""
    wrong, touched, held, slowed = 0, 0, 0, 0
    for _ in range(scenes):
        rows, walls, motion, command = a_scene(random)
        sent, row = largest_share(rows, walls, body, motion, command, 0.0)
        found = own_speeds(rows, walls, body, motion, sent * command, 0.0)
        braked = own_speeds(rows, walls, body, motion, 0.0 * command, 0.0)
        allowed = np.maximum(rows[:, 8], SLOWEST)
        held += sent == 0.0
        slowed += 0.0 < sent < 1.0
        touched += np.any(braked > allowed)
        approached = is_approached(rows, motion, command)
        for k in range(len(rows)):
            wrong += approached[k] and found[k] > max(allowed[k], braked[k]) + 1e-6
        wrong += sent < 1.0 and not np.any(approached)
        wrong += (sent < 1.0) != (row >= 0)
    return wrong, touched, held, slowed


def test_no_command_is_sent_that_can_touch_in_motion_where_braking_would_not():
    wrong, touched, held, slowed = odd_scenes(np.random.default_rng(1), SCENES, BODY)
    assert wrong == 0
    # scenes of every kind
    assert min(touched, held, slowed, SCENES - touched) > SCENES // 50, (touched, held, slowed)


@njit
def a_way(random, rows, k, steps):
    """(steps, 2) places of a mover that leaves its predicted way as fast as it may, to and fro."""
    way, x, y, angle = np.empty((steps, 2)), 0.0, 0.0, random.uniform(-np.pi, np.pi)
    along = random.random()
    for s in range(steps):
        if random.random() < 0.05:
            angle = random.uniform(-np.pi, np.pi)
        x, y = x + rows[k, 7] * 0.01 * math.cos(angle), y + rows[k, 7] * 0.01 * math.sin(angle)
        way[s, 0] = rows[k, 0] + along * (rows[k, 2] - rows[k, 0]) + (s + 1) * 0.01 * rows[k, 4] + x
        way[s, 1] = rows[k, 1] + along * (rows[k, 3] - rows[k, 1]) + (s + 1) * 0.01 * rows[k, 5] + y
    return way


@njit
def after(law, motion, command):
    x, y, vx, vy = motion
    wx, wy = velocity_after_step(law, vx, vy, command[0], command[1])
    return np.array([x + 0.5 * STEP * (vx + wx), y + 0.5 * STEP * (vy + wy), wx, wy])


@njit
def first_touches(random, scenes, body):
    """By how much the own speed is above what is allowed at first touches of movers that walk at random as they may."""
    excess = []
    for _ in range(scenes):
        rows, walls, start, command = a_scene(random)
        sent, _ = largest_share(rows, walls[:0], body, start, command, 0.0)
        braked = own_speeds(rows, walls[:0], body, start, 0.0 * command, 0.0)
        for k in np.flatnonzero(braked <= np.maximum(rows[:, 8], SLOWEST)):
            way, motion = a_way(random, rows, k, 200), start
            for s in range(200):
                motion = after(body.brakes, motion, sent * command if s < body.held else 0.0 * command)
                dx, dy = way[s, 0] - motion[0], way[s, 1] - motion[1]
                far = math.hypot(dx, dy)
                if far < body.radius + rows[k, 6]:
                    if s > 0:
                        excess.append((motion[2] * dx + motion[3] * dy) / max(far, 1e-9) - max(rows[k, 8], SLOWEST))
                    break
    return np.array(excess)


def test_movers_that_leave_their_way_as_they_may_touch_no_robot_that_drives_at_them():
    """By a simulation of its own. What steps in front of a robot that passes by is judged by where it was expected."""
    excess = first_touches(np.random.default_rng(2), SCENES // 2, BODY)
    assert len(excess) > 5000
    assert (excess > 0.02).mean() < 0.01
    assert (excess > 0.2).mean() < 0.0005


@pytest.mark.parametrize("speed", [0.3, 0.6, 1.2])
@pytest.mark.parametrize("comes", [0.0, 0.5, 1.0])
def test_it_stops_before_what_comes_by_the_braking_distance(speed, comes):
    """S = K T + C by hand: the way of the robot and that of the mover until the robot stands."""
    held, braking = BODY.held * STEP, BODY.brakes.max_acceleration
    linear = braking * BODY.brakes.lag
    duration = held + (speed - linear) / braking + BODY.brakes.lag * math.log(linear / SLOWEST)
    way = held * speed + (speed**2 - linear**2) / (2.0 * braking) + BODY.brakes.lag * (linear - SLOWEST)
    gap = way + (comes + GROWTH) * duration + CLEARANCE
    motion, command, reach = (0.0, 0.0, speed, 0.0), (speed, 0.0), BODY.radius + 0.12
    assert share(disc(reach + gap + 0.03, vx=-comes), motion, command) == (1.0, -1)
    sent, row = share(disc(reach + gap - 0.03, vx=-comes), motion, command)
    assert (sent < 1.0, row) == (True, 0)


def test_one_that_stands_or_leaves_is_free_and_one_that_has_nothing_near_is_not_looked_at():
    comes = disc(0.30, vx=-0.8)
    assert share([], DRIVES) == (1.0, -1)
    assert share(comes, REST, (0.0, 0.0)) == (1.0, -1)
    for angle in np.linspace(0.5 * np.pi, 1.5 * np.pi, 13):
        away = np.array([math.cos(angle), math.sin(angle)])
        for speed in (0.0, 0.5, 1.2):
            motion = np.array([0.0, 0.0, *(speed * away)])
            assert share(comes, motion, 1.2 * away) == (1.0, -1), (angle, speed)
    # also from one that is faster, and from one that touches it already
    assert share(disc(-0.25, vx=2.0), DRIVES) == (1.0, -1)
    assert share(disc(-0.15, vx=2.0), REST) == (1.0, -1)
    assert share(disc(5.0), DRIVES) == (1.0, -1)


def test_it_counts_on_rebounds_and_a_wall_in_front_of_a_mover_saves_it():
    wall = np.array([[0.35, -1.0, 0.35, 1.0]])
    behind = disc(0.75, growth=0.0)
    assert share(behind, DRIVES, walls=wall) == (1.0, -1)
    assert share(behind, DRIVES)[0] < 1.0


def test_a_command_that_is_as_slow_as_may_be_is_never_held():
    ahead = disc(0.3)
    assert share(ahead, REST, (0.3, 0.0), least=1.0) == (1.0, -1)
    sent, row = share(ahead, REST, (1.2, 0.0), least=0.25)
    assert (0.25 <= sent < 0.5, row) == (True, 0)


def drive_along(rows, way):
    motion, periods, courses = REST, BODY.held - 3, []
    while motion[0] < way:
        sent, _ = share(rows, motion)
        for _ in range(periods):
            motion = after(BODY.drives, motion, sent * ALONG_X)
        courses.append((motion[0], motion[2]))
        assert len(courses) < 400, motion
    return np.array(courses)


@pytest.mark.parametrize("speed", [0.5, 1.0])
def test_past_an_edge_out_of_which_something_may_come_it_creeps_and_then_drives_on(speed):
    # an edge away from a tip that is 0.12 m beside the way, 1.5 m ahead
    x, v = drive_along([1.5, 0.12, 1.8, 0.3, 0.0, 0.0, 0.0, speed, 0.1, 0.0], 2.5).T
    before, beside, behind = x < 0.4, (x > 1.3) & (x < 1.45), x > 2.2
    assert v[before].max() > 0.6
    assert 0.1 < v[beside].min() <= v[beside].max() < 0.35
    assert v[behind].min() > 0.6
    assert (np.abs(np.diff(v)) < 0.08).all()  # no stop and go
