"""run.gif: the run as it went: scan, free space, plan and robot, in the world that the robot does not know."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from collplan_core.local_map import build_local_map
from collplan_core.params import Settings
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.worlds import World
from collplan_ros.impact_log import Impacts
from collplan_ros.run_log import PlanRow, RunLog

FRAME_PERIOD = 0.1
"""Between two frames of a short run [s]."""
MOST_FRAMES = 110
"""A longer run is shown in fewer frames per second, at the same speed."""
LONG_SIDE = 460
"""Of the picture, caption apart [pixel]."""
CAPTION = 22
SMOOTHING = 2
"""Frames are drawn so much larger and reduced: edges become smooth."""
N_COLORS = 64
FLASH_TIME = 0.3
"""How long an impact lights up [s]."""
LAST_FRAME = 1500
"""How long the last frame stays [ms]."""

FLOOR, OBSTACLE, WALL, FREE, HIT, PLAN, TRAIL, ROBOT, GOAL, IMPACT, TEXT = (
    "#f4f5f7", "#c9ced6", "#8a919c", "#cfe8d5", "#27408b", "#d9480f", "#8e6bbf", "#2b2d33", "#1a8f4c", "#e3172d",
    "#2b2d33",
)  # fmt: skip

Point = tuple[float, float]


@dataclass(frozen=True)
class _Canvas:
    """Where a point of the world lies in the picture; drawn at SMOOTHING times its size."""

    x0: float
    y1: float
    scale: float
    size: tuple[int, int]

    def at(self, points: np.ndarray) -> list[Point]:
        """Pixels of points (k, 2)."""
        return [((x - self.x0) * self.scale, (self.y1 - y) * self.scale) for x, y in np.atleast_2d(points).tolist()]

    def disc(self, center: np.ndarray, radius: float) -> list[float]:
        """Box of a disc, for Pillow."""
        ((x, y),) = self.at(center)
        r = radius * self.scale
        return [x - r, y - r, x + r, y + r]


def draw_animation(
    path: Path, log: RunLog, impacts: Impacts, world: World, goal: np.ndarray, settings: Settings
) -> None:
    """Writes the animation at the run's own speed; nothing where no scan was received."""
    stamps, period = _frame_stamps(log)
    if len(stamps) == 0:
        return
    canvas = _canvas(world)
    background = _background(canvas, world)
    frames = [_frame(stamp, background, canvas, log, impacts, goal, settings) for stamp in stamps]
    palette = frames[len(frames) // 2].quantize(N_COLORS)
    frames = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    durations = [round(1e3 * period)] * (len(frames) - 1) + [LAST_FRAME]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=durations, loop=0, optimize=True)


def _frame_stamps(log: RunLog) -> tuple[np.ndarray, float]:
    if not log.scans or not log.track:
        return np.zeros(0), FRAME_PERIOD
    begin = max(log.scans[0].stamp, log.track[0].stamp, (log.time_zero or 0.0) - 2 * FRAME_PERIOD)
    span = max(log.track[-1].stamp - begin, 0.0)
    period = max(FRAME_PERIOD, round(span / MOST_FRAMES, 2))  # GIF counts in hundredths of a second
    return begin + period * np.arange(int(span / period) + 1), period


def _canvas(world: World) -> _Canvas:
    x0, y0, x1, y1 = world.bounds
    margin = 0.02 * max(x1 - x0, y1 - y0)
    width, height = x1 - x0 + 2 * margin, y1 - y0 + 2 * margin
    scale = SMOOTHING * LONG_SIDE / max(width, height)
    size = (round(width * scale), round(height * scale))
    return _Canvas(x0 - margin, y1 + margin, scale, size)


def _background(canvas: _Canvas, world: World) -> Image.Image:
    image = Image.new("RGB", (canvas.size[0], canvas.size[1] + SMOOTHING * CAPTION), FLOOR)
    draw = ImageDraw.Draw(image)
    for corners in world.polygons:
        draw.polygon(canvas.at(corners), fill=OBSTACLE, outline=WALL)
    for x, y, r in world.circles:
        draw.ellipse(canvas.disc(np.array([x, y]), r), fill=OBSTACLE, outline=WALL)
    (left, top), (right, bottom) = canvas.at(np.array([world.bounds[0::3], world.bounds[2:0:-1]]))
    draw.rectangle([left, top, right, bottom], outline=WALL, width=(2 if world.walled else 1) * SMOOTHING)
    return image


def _frame(
    stamp: float,
    background: Image.Image,
    canvas: _Canvas,
    log: RunLog,
    impacts: Impacts,
    goal: np.ndarray,
    settings: Settings,
) -> Image.Image:
    image = background.copy()
    draw = ImageDraw.Draw(image)
    scan = log.scans[_newest(stamp, [s.stamp for s in log.scans])]
    _draw_scan(draw, canvas, scan, _state_at(scan.stamp, log), settings)
    draw.ellipse(canvas.disc(goal, settings.planner.goal_tolerance), outline=GOAL, width=2 * SMOOTHING)
    draw.ellipse(canvas.disc(goal, 0.2 * settings.planner.goal_tolerance), fill=GOAL)
    _draw_motion(draw, canvas, stamp, log, settings.robot.radius)
    recent = (impacts.times <= stamp) & (impacts.times > stamp - FLASH_TIME)
    for point in impacts.points[recent]:
        draw.ellipse(canvas.disc(point, 0.035), fill=IMPACT)
    small = image.reduce(SMOOTHING)
    _write_caption(small, stamp, log, int((impacts.times <= stamp).sum()))
    return small


def _draw_scan(draw: ImageDraw.ImageDraw, canvas: _Canvas, scan: Scan, state: State, settings: Settings) -> None:
    draw.polygon(canvas.at(build_local_map(scan, state, settings.robot, settings.local_map).points), fill=FREE)
    hit = np.isfinite(scan.ranges)
    angles = scan.angles[hit] + state.yaw
    for x, y in canvas.at(state.position + scan.ranges[hit, None] * np.column_stack([np.cos(angles), np.sin(angles)])):
        draw.rectangle([x - 1, y - 1, x + 1, y + 1], fill=HIT)


def _draw_motion(draw: ImageDraw.ImageDraw, canvas: _Canvas, stamp: float, log: RunLog, radius: float) -> None:
    track = np.array([row[1:3] for row in log.track if row.stamp <= stamp]).reshape(-1, 2)
    if len(track) > 1:
        draw.line(canvas.at(track[::3]), fill=TRAIL, width=2 * SMOOTHING, joint="curve")
    plan = _plan_at(stamp, log.plans)
    if plan is not None:
        draw.line(canvas.at(plan.positions), fill=PLAN, width=2 * SMOOTHING, joint="curve")
        draw.ellipse(canvas.disc(plan.positions[-1], 0.02), fill=PLAN)
    state = _state_at(stamp, log)
    draw.ellipse(canvas.disc(state.position, radius), fill="white", outline=ROBOT, width=2 * SMOOTHING)
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
