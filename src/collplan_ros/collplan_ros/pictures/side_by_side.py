"""Animation of runs in the same world beside each other, at the same time scale."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from collplan_core.evaluation.run_end import REACHED
from collplan_ros.pictures.drawing import (
    SMOOTHING,
    SPEED_COLORS,
    Canvas,
    background,
    canvas_of,
    draw_goal,
    draw_mark,
    draw_marks,
    draw_robot,
    draw_trail,
    speed_color,
)
from collplan_ros.pictures.gif_file import save_gif
from collplan_ros.pictures.legend import font
from collplan_ros.pictures.palette import FAILED, FLOOR, GOAL, TEXT, WALL
from collplan_ros.pictures.shown_run import ShownRun

FRAME_PERIOD = 0.05
"""Time between two frames [s]."""
LAST_FRAME = 3.0
"""How long the last frame stays [s]."""
LONG_SIDE = 420
"""Longer side of each run's picture [pixel]."""
AROUND = 0.3
"""Margin shown around the paths of the robots [m]."""
HEAD, FOOT = 50, 46
"""Height of the text above each run, and below all of them [pixel]."""
GAP, MARGIN = 10, 8
"""Distance between runs, and of text from the edge [pixel]."""
LARGE, SMALL = 18, 13
"""Sizes of the font [pixel]."""


def draw_side_by_side(path: Path, runs: Sequence[ShownRun], speed: float) -> None:
    """Writes a GIF of runs in one world at `speed` times real time; each starts at its first non-zero command."""
    canvas = canvas_of(_view(runs), LONG_SIDE)
    step = speed * FRAME_PERIOD
    count = int(max(run.end for run in runs) / step) + 2
    panels = [_panels(run, canvas, (k * step for k in range(count))) for run in runs]
    foot = _foot(runs, len(runs) * (panels[0][0].width + GAP) - GAP, speed)
    frames = [_joined(each, foot) for each in zip(*panels, strict=True)]
    save_gif(path, frames, FRAME_PERIOD, LAST_FRAME)


def _view(runs: Sequence[ShownRun]) -> tuple[float, float, float, float]:
    """Bounds x0, y0, x1, y1 [m] of the part of the world to show: the paths of the robots and a margin."""
    points = np.vstack([np.vstack([run.trail.points, run.goal]) for run in runs])
    bounds = np.array(runs[0].recorded.world.bounds)
    x0, y0 = np.maximum(points.min(axis=0) - AROUND, bounds[:2]).tolist()
    x1, y1 = np.minimum(points.max(axis=0) + AROUND, bounds[2:]).tolist()
    return x0, y0, x1, y1


def _panels(run: ShownRun, canvas: Canvas, times: Iterable[float]) -> list[Image.Image]:
    empty = background(canvas, run.recorded.world)
    draw_goal(ImageDraw.Draw(empty), canvas, run.goal, run.recorded.settings.planner.goal_tolerance)
    return [_panel(run, canvas, empty, min(time, run.end)) for time in times]


def _panel(run: ShownRun, canvas: Canvas, empty: Image.Image, time: float) -> Image.Image:
    drawn = empty.copy()
    draw = ImageDraw.Draw(drawn)
    draw_trail(draw, canvas, run.trail, time)
    draw_robot(draw, canvas, run.trail.at(time), run.recorded.settings.robot.radius)
    draw_marks(draw, canvas, run.marks, time)
    world = drawn.reduce(SMOOTHING)
    panel = Image.new("RGB", (world.width, world.height + HEAD), FLOOR)
    panel.paste(world, (0, HEAD))
    _write_head(ImageDraw.Draw(panel), run, time, world.width)
    return panel


def _write_head(draw: ImageDraw.ImageDraw, run: ShownRun, time: float, width: int) -> None:
    """Writes strategy, impacts so far, and the clock, which stops at the end of the run."""
    deliberate = run.marks.deliberate[run.marks.times <= time]
    contacts = f"contacts: {deliberate.sum()} deliberate, {(~deliberate).sum()} other"
    ended, reached = time >= run.end, run.outcome == REACHED
    clock = f"{'goal at ' if ended and reached else ''}{time:.2f} s{'' if reached or not ended else ', ' + run.outcome}"
    color = TEXT if not ended else GOAL if reached else FAILED
    draw.text((MARGIN, 6), run.recorded.settings.planner.strategy, fill=TEXT, font=font(LARGE))
    draw.text((MARGIN, 29), contacts, fill=TEXT, font=font(SMALL))
    draw.text((width - MARGIN, 6), clock, fill=color, font=font(LARGE), anchor="ra")


def _foot(runs: Sequence[ShownRun], width: int, speed: float) -> Image.Image:
    """Picture of the legend and of the properties of the runs."""
    drawn = Image.new("RGB", (SMOOTHING * width, SMOOTHING * FOOT), FLOOR)
    draw = ImageDraw.Draw(drawn)
    y, right = SMOOTHING * 13, SMOOTHING * width
    draw_mark(draw, SMOOTHING * 16, y, SMOOTHING * 6, True)
    draw_mark(draw, SMOOTHING * 186, y, SMOOTHING * 6, False)
    for k in range(SPEED_COLORS):
        left = right - SMOOTHING * (8 + 8 * (SPEED_COLORS - k))
        draw.rectangle([left, y - SMOOTHING * 3, left + 8 * SMOOTHING, y + SMOOTHING * 3], fill=speed_color(k))
    draw.line([0, 0, right, 0], fill=WALL, width=SMOOTHING)
    foot = drawn.reduce(SMOOTHING)
    text = ImageDraw.Draw(foot)
    text.text((28, 6), "deliberate contact", fill=TEXT, font=font(SMALL))
    text.text((198, 6), "other contact", fill=TEXT, font=font(SMALL))
    top = max(run.recorded.settings.robot.max_speed for run in runs)
    text.text((width - 16 - 8 * SPEED_COLORS, 6), f"speed 0 to {top:g} m/s", fill=TEXT, font=font(SMALL), anchor="ra")
    text.text((MARGIN, 25), _about(runs, speed), fill=TEXT, font=font(SMALL))
    return foot


def _about(runs: Sequence[ShownRun], speed: float) -> str:
    """Kind, world, seed and a_max of the runs, and the pace of the animation."""
    pace = "real time" if speed == 1.0 else f"{speed:g} times real time"
    return ";  ".join(
        (
            _each(runs, lambda run: "simulated" if run.recorded.simulated else "measured"),
            f"world {_each(runs, lambda run: run.recorded.world.name)}",
            f"seed {_each(runs, lambda run: str(run.recorded.settings.simulator.seed))}",
            f"a_max {_each(runs, lambda run: f'{run.recorded.settings.robot.max_acceleration:g}')} m/s^2",
            pace,
        )
    )


def _each(runs: Sequence[ShownRun], word: Callable[[ShownRun], str]) -> str:
    """The word of each run, only once if all are equal."""
    words = [word(run) for run in runs]
    return words[0] if len(set(words)) == 1 else ", ".join(words)


def _joined(panels: Sequence[Image.Image], foot: Image.Image) -> Image.Image:
    width, height = panels[0].size
    image = Image.new("RGB", (foot.width, height + foot.height), FLOOR)
    for k, panel in enumerate(panels):
        image.paste(panel, (k * (width + GAP), 0))
    image.paste(foot, (0, height))
    return image
