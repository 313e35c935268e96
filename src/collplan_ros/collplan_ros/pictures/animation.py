"""run.gif: animation of a run with scan, free space, plan and robot, in the world that the robot does not know."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from collplan_core.local_map import build_local_map
from collplan_core.parameters import Settings
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.worlds import World
from collplan_ros.pictures.drawing import (
    ROBOT,
    SMOOTHING,
    TEXT,
    Canvas,
    Marks,
    Trail,
    background,
    canvas_of,
    draw_goal,
    draw_marks,
    draw_robot,
    draw_trail,
    save_gif,
    trail_of,
)
from collplan_ros.runs.impact_log import Impacts
from collplan_ros.runs.run_log import PlanRow, RunLog

FRAME_PERIOD = 0.1
"""Time between two frames of a short run [s]."""
MOST_FRAMES = 110
"""Longer runs are shown with fewer frames per second, at the same speed."""
LONG_SIDE = 460
"""Longer side of the picture, without the caption [pixel]."""
CAPTION = 22
"""Height of the caption [pixel]."""
LAST_FRAME = 1.5
"""How long the last frame stays [s]."""

FREE, BEAM_END, PLAN = "#cfe8d5", "#27408b", "#d9480f"


@dataclass(frozen=True, eq=False)
class _Animated:
    """What every frame of a run is drawn from.

    Attributes:
        log: the run.
        background: picture of the world.
        canvas: its scale.
        trail: where the robot went.
        marks: its impacts.
        goal: (2,) [m].
        settings: parameters of the run.
    """

    log: RunLog
    background: Image.Image
    canvas: Canvas
    trail: Trail
    marks: Marks
    goal: np.ndarray
    settings: Settings


def draw_animation(
    path: Path, log: RunLog, impacts: Impacts, world: World, goal: np.ndarray, settings: Settings
) -> None:
    """Writes the animation of a run in real time; nothing if no scan was received. The goal is (2,) [m]."""
    stamps, period = _frame_stamps(log)
    if len(stamps) == 0:
        return
    canvas = canvas_of(world.bounds, LONG_SIDE)
    rows = np.array([row[:3] for row in log.track])
    trail = trail_of(rows[:, 0], rows[:, 1:], settings.robot.max_speed)
    marks = Marks(impacts.times, impacts.points, impacts.deliberate)
    run = _Animated(log, background(canvas, world, CAPTION), canvas, trail, marks, goal, settings)
    save_gif(path, [_frame(run, stamp) for stamp in stamps], period, LAST_FRAME)


def _frame_stamps(log: RunLog) -> tuple[np.ndarray, float]:
    if not log.scans or not log.track:
        return np.zeros(0), FRAME_PERIOD
    begin = max(log.scans[0].stamp, log.track[0].stamp, (log.time_zero or 0.0) - 2 * FRAME_PERIOD)
    span = max(log.track[-1].stamp - begin, 0.0)
    period = max(FRAME_PERIOD, round(span / MOST_FRAMES, 2))  # GIF counts in hundredths of a second
    return begin + period * np.arange(int(span / period) + 1), period


def _frame(run: _Animated, stamp: float) -> Image.Image:
    image = run.background.copy()
    draw = ImageDraw.Draw(image)
    scan = run.log.scans[_newest(stamp, [s.stamp for s in run.log.scans])]
    _draw_scan(draw, run.canvas, scan, _state_at(scan.stamp, run.log), run.settings)
    draw_goal(draw, run.canvas, run.goal, run.settings.planner.goal_tolerance)
    draw_trail(draw, run.canvas, run.trail, stamp)
    _draw_plan(draw, run.canvas, _plan_at(stamp, run.log.plans))
    draw_marks(draw, run.canvas, run.marks, stamp)
    _draw_robot(draw, run.canvas, _state_at(stamp, run.log), run.settings.robot.radius)
    small = image.reduce(SMOOTHING)
    _write_caption(small, stamp, run.log, int((run.marks.times <= stamp).sum()))
    return small


def _draw_scan(draw: ImageDraw.ImageDraw, canvas: Canvas, scan: Scan, state: State, settings: Settings) -> None:
    draw.polygon(canvas.at(build_local_map(scan, state, settings.robot, settings.local_map).border_points), fill=FREE)
    hit = np.isfinite(scan.ranges)
    angles = scan.angles[hit] + state.yaw
    for x, y in canvas.at(state.position + scan.ranges[hit, None] * np.column_stack([np.cos(angles), np.sin(angles)])):
        draw.rectangle([x - 1, y - 1, x + 1, y + 1], fill=BEAM_END)


def _draw_plan(draw: ImageDraw.ImageDraw, canvas: Canvas, plan: PlanRow | None) -> None:
    if plan is not None:
        draw.line(canvas.at(plan.positions), fill=PLAN, width=2 * SMOOTHING, joint="curve")
        draw.ellipse(canvas.disc(plan.positions[-1], 0.02), fill=PLAN)


def _draw_robot(draw: ImageDraw.ImageDraw, canvas: Canvas, state: State, radius: float) -> None:
    draw_robot(draw, canvas, state.position, radius)
    nose = state.position + radius * np.array([np.cos(state.yaw), np.sin(state.yaw)])
    draw.line(canvas.at(np.array([state.position, nose])), fill=ROBOT, width=2 * SMOOTHING)


def _write_caption(image: Image.Image, stamp: float, log: RunLog, n_impacts: int) -> None:
    maneuver = _last(stamp, [(c.stamp, c.maneuver) for c in log.commands]) or ""
    elapsed = max(0.0, stamp - (log.time_zero if log.time_zero is not None else stamp))
    text = f"{elapsed:4.1f} s    {maneuver.replace('_', ' ')}    impacts {n_impacts}"
    ImageDraw.Draw(image).text((8, image.height - CAPTION + 4), text, fill=TEXT)


def _newest(stamp: float, stamps: list[float]) -> int:
    return max(int(np.searchsorted(stamps, stamp, side="right")) - 1, 0)


def _last(stamp: float, rows: list[tuple[float, str]]) -> str | None:
    return next((value for at, value in reversed(rows) if at <= stamp), None)


def _plan_at(stamp: float, plans: list[PlanRow]) -> PlanRow | None:
    return next((plan for plan in reversed(plans) if plan.stamp <= stamp), None)


def _state_at(stamp: float, log: RunLog) -> State:
    row = log.poses[_newest(stamp, [p.stamp for p in log.poses])]
    return State(row.stamp, np.array([row.x, row.y]), np.array([row.vx, row.vy]), row.yaw)
