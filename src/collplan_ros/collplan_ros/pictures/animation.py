"""run.gif: animation of a run with scan, free space, plan and robot, in the world that the robot does not know."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from collplan_core.local_map import build_local_map
from collplan_core.parameters import Settings
from collplan_core.planners import local_mapping_of
from collplan_core.scan import Scan
from collplan_core.sensing.beam_poses import placed_among
from collplan_core.state import State
from collplan_core.worlds import World
from collplan_ros.pictures.drawing import (
    SMOOTHING,
    Canvas,
    Marks,
    Trail,
    background,
    canvas_of,
    draw_goal,
    draw_marks,
    draw_robot,
    draw_trail,
    trail_of,
)
from collplan_ros.pictures.gif_file import save_gif
from collplan_ros.pictures.legend import MARGIN, font, legend, run_entries
from collplan_ros.pictures.palette import FLOOR, FREE, PLAN, ROBOT, SCAN, TEXT, WALL
from collplan_ros.pictures.title import shortened
from collplan_ros.runs.impact_log import Impacts
from collplan_ros.runs.run_log import PlanRow, RunLog, states_around
from collplan_ros.runs.summary import counted_impacts

FRAME_PERIOD = 0.1
"""Time between two frames of a short run [s]."""
MOST_FRAMES = 110
"""Longer runs are shown with fewer frames per second, at the same speed."""
LONG_SIDE = 460
"""Longer side of the picture, without the text below [pixel]."""
NARROWEST = 0.65
"""Least width of what is shown, in its heights: the text below needs room."""
CLOCK, TITLE = 30, 24
"""Height of the lines with the time and with the title [pixel]."""
LARGE, SMALL = 16, 12
"""Sizes of the font [pixel]."""
MANEUVER_AT = 74
"""Where the maneuver begins, right of the time [pixel]."""
WIDE_SPACE = "  "
"""One space of the font is hardly to be seen."""
LAST_FRAME = 1.5
"""How long the last frame stays [s]."""


@dataclass(frozen=True, eq=False)
class _Animated:
    """What every frame of a run is drawn from.

    Attributes:
        log: the run.
        background: picture of the world.
        canvas: its scale.
        foot: picture of legend and title.
        trail: where the robot went.
        marks: its impacts.
        goal: (2,) [m].
        settings: parameters of the run.
    """

    log: RunLog
    background: Image.Image
    canvas: Canvas
    foot: Image.Image
    trail: Trail
    marks: Marks
    goal: np.ndarray
    settings: Settings


def draw_animation(
    path: Path, log: RunLog, impacts: Impacts, world: World, goal: np.ndarray, settings: Settings, title: str
) -> None:
    """Writes the animation of a run in real time; nothing if no scan was received. The goal is (2,) [m]."""
    stamps, period = _frame_stamps(log)
    if len(stamps) == 0:
        return
    canvas = canvas_of(_view(world), LONG_SIDE)
    empty = background(canvas, world)
    rows = np.array([row[:3] for row in log.track])
    top_speed = settings.robot.max_speed
    trail = trail_of(rows[:, 0], rows[:, 1:], top_speed)
    marks = Marks(impacts.times, impacts.points, impacts.deliberate)
    foot = _foot(empty.width // SMOOTHING, top_speed, title)
    run = _Animated(log, empty, canvas, foot, trail, marks, goal, settings)
    save_gif(path, [_frame(run, stamp) for stamp in stamps], period, LAST_FRAME)


def _view(world: World) -> tuple[float, float, float, float]:
    """Bounds x0, y0, x1, y1 [m] of what is shown: the world's, wider where it is narrow."""
    x0, y0, x1, y1 = world.bounds
    beside = 0.5 * max(0.0, NARROWEST * (y1 - y0) - (x1 - x0))
    return x0 - beside, y0, x1 + beside, y1


def _frame_stamps(log: RunLog) -> tuple[np.ndarray, float]:
    if not log.scans or not log.track:
        return np.zeros(0), FRAME_PERIOD
    begin = max(log.scans[0].stamp, log.track[0].stamp, (log.time_zero or 0.0) - 2 * FRAME_PERIOD)
    span = max(log.track[-1].stamp - begin, 0.0)
    period = max(FRAME_PERIOD, round(span / MOST_FRAMES, 2))  # GIF counts in hundredths of a second
    return begin + period * np.arange(int(span / period) + 1), period


def _frame(run: _Animated, stamp: float) -> Image.Image:
    drawn = run.background.copy()
    draw = ImageDraw.Draw(drawn)
    scan = run.log.scans[_newest(stamp, [s.stamp for s in run.log.scans])]
    at = _state_at(scan.stamp, run.log)
    shown = placed_among(scan, at, states_around(run.log.poses, scan), run.settings.scan)
    _draw_scan(draw, run.canvas, shown, at, run.settings)
    draw_goal(draw, run.canvas, run.goal, run.settings.planner.goal_tolerance)
    draw_trail(draw, run.canvas, run.trail, stamp)
    _draw_plan(draw, run.canvas, _plan_at(stamp, run.log.plans))
    draw_marks(draw, run.canvas, run.marks, stamp)
    _draw_robot(draw, run.canvas, _state_at(stamp, run.log), run.settings.robot.radius)
    world = drawn.reduce(SMOOTHING)
    image = Image.new("RGB", (world.width, world.height + CLOCK + run.foot.height), FLOOR)
    image.paste(world, (0, 0))
    image.paste(run.foot, (0, world.height + CLOCK))
    _write_clock(ImageDraw.Draw(image), world.size, stamp, run)
    return image


def _draw_scan(draw: ImageDraw.ImageDraw, canvas: Canvas, scan: Scan, state: State, settings: Settings) -> None:
    local_map = build_local_map(scan, state, settings.robot, local_mapping_of(settings))
    draw.polygon(canvas.at(local_map.border_points), fill=FREE)
    for x, y in canvas.at(scan.points(state, np.isfinite(scan.ranges))):
        draw.rectangle([x - 1, y - 1, x + 1, y + 1], fill=SCAN)


def _draw_plan(draw: ImageDraw.ImageDraw, canvas: Canvas, plan: PlanRow | None) -> None:
    if plan is not None:
        draw.line(canvas.at(plan.positions), fill=PLAN, width=2 * SMOOTHING, joint="curve")
        draw.ellipse(canvas.disc(plan.positions[-1], 0.02), fill=PLAN)


def _draw_robot(draw: ImageDraw.ImageDraw, canvas: Canvas, state: State, radius: float) -> None:
    draw_robot(draw, canvas, state.position, radius)
    nose = state.position + radius * np.array([np.cos(state.yaw), np.sin(state.yaw)])
    draw.line(canvas.at(np.array([state.position, nose])), fill=ROBOT, width=2 * SMOOTHING)


def _write_clock(draw: ImageDraw.ImageDraw, world: tuple[int, int], stamp: float, run: _Animated) -> None:
    """Writes time, maneuver and number of impacts under the picture of the world, `world` pixels wide and high."""
    log, (width, y) = run.log, (world[0], world[1] + 0.5 * CLOCK)
    maneuver = _last(stamp, [(c.stamp, c.maneuver) for c in log.commands]) or ""
    elapsed = max(0.0, stamp - (log.time_zero if log.time_zero is not None else stamp))
    impacts = counted_impacts(int((run.marks.times <= stamp).sum())).replace(" ", WIDE_SPACE)
    draw.line([0, world[1], width, world[1]], fill=WALL)
    draw.text((MANEUVER_AT - 12, y), f"{elapsed:.1f}{WIDE_SPACE}s", fill=TEXT, font=font(LARGE), anchor="rm")
    draw.text((MANEUVER_AT, y), maneuver.replace("_", " "), fill=TEXT, font=font(SMALL), anchor="lm")
    draw.text((width - MARGIN, y), impacts, fill=TEXT, font=font(LARGE), anchor="rm")


def _foot(width: int, top_speed: float, title: str) -> Image.Image:
    """Picture of legend and title, `width` pixels wide."""
    explained = legend(width, run_entries(top_speed))
    image = Image.new("RGB", (width, explained.height + TITLE), FLOOR)
    image.paste(explained, (0, 0))
    words = shortened(title, lambda text: font(SMALL).getlength(text) <= width - 2 * MARGIN)
    where = (MARGIN, explained.height + 0.5 * TITLE)
    ImageDraw.Draw(image).text(where, words, fill=TEXT, font=font(SMALL), anchor="lm")
    return image


def _newest(stamp: float, stamps: list[float]) -> int:
    return max(int(np.searchsorted(stamps, stamp, side="right")) - 1, 0)


def _last(stamp: float, rows: list[tuple[float, str]]) -> str | None:
    return next((value for at, value in reversed(rows) if at <= stamp), None)


def _plan_at(stamp: float, plans: list[PlanRow]) -> PlanRow | None:
    return next((plan for plan in reversed(plans) if plan.stamp <= stamp), None)


def _state_at(stamp: float, log: RunLog) -> State:
    return log.poses[_newest(stamp, [p.stamp for p in log.poses])].state
