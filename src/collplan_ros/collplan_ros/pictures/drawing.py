"""Drawing of world, trail, robot, goal and impacts in the frames of an animation."""

import math
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw

from collplan_core.worlds import World
from collplan_ros.pictures.palette import (
    DELIBERATE,
    FLOOR,
    GOAL,
    OBSTACLE,
    OTHER,
    OUTLINE,
    ROBOT,
    WALL,
    speed_colors,
)

SMOOTHING = 2
"""Factor by which frames are drawn larger and then reduced, for smooth edges."""
FLASH_TIME = 0.3
"""Time for which a new impact is drawn larger [s]."""
MARK, FLASH = 0.028, 0.06
"""Radius of an impact's mark, and of a new one [m]."""
DIAMOND = 1.2
"""Half the diagonal of a diamond that looks as large as a disc of radius 1."""
SPEED_SPAN = 3
"""A speed is computed from the points so many before and after."""
SPEED_COLORS = 12
"""Number of colours that speeds are shown in."""
TRAIL_WIDTH = 2.5
"""Width of a trail [pixel]."""


Point = tuple[float, float]


@dataclass(frozen=True)
class Canvas:
    """Transform from the world to pixels of a picture drawn at SMOOTHING times its size.

    Attributes:
        x0: world coordinate of the left edge [m].
        y1: world coordinate of the upper edge [m].
        scale: [pixel/m].
        size: width and height [pixel].
    """

    x0: float
    y1: float
    scale: float
    size: tuple[int, int]

    def at(self, points: np.ndarray) -> list[Point]:
        """Pixel coordinates of points (k, 2) [m]."""
        return [((x - self.x0) * self.scale, (self.y1 - y) * self.scale) for x, y in np.atleast_2d(points).tolist()]

    def disc(self, center: np.ndarray, radius: float) -> list[float]:
        """Bounding box of a disc [pixel], for Pillow, from centre (2,) and radius [m]."""
        ((x, y),) = self.at(center)
        return box(x, y, radius * self.scale)


@dataclass(frozen=True, eq=False)
class Trail:
    """Path of a robot: times (n,) [s], points (n, 2) [m], and the index (n,) of the colour of its speed."""

    times: np.ndarray
    points: np.ndarray
    color: np.ndarray

    def at(self, time: float) -> np.ndarray:
        """The point (2,) at a time [s]."""
        return np.array([np.interp(time, self.times, each) for each in self.points.T])


@dataclass(frozen=True, eq=False)
class Marks:
    """Impacts to draw: times (k,) [s], points (k, 2) [m], and whether each was deliberate (k,)."""

    times: np.ndarray
    points: np.ndarray
    deliberate: np.ndarray


def canvas_of(view: tuple[float, float, float, float], long_side: int) -> Canvas:
    """The canvas on which the view (x0, y0, x1, y1) [m] with a margin has a longer side of `long_side` pixels."""
    x0, y0, x1, y1 = view
    margin = 0.02 * max(x1 - x0, y1 - y0)
    width, height = x1 - x0 + 2 * margin, y1 - y0 + 2 * margin
    scale = SMOOTHING * long_side / max(width, height)
    return Canvas(x0 - margin, y1 + margin, scale, (round(width * scale), round(height * scale)))


def trail_of(times: np.ndarray, points: np.ndarray, top_speed: float) -> Trail:
    """The trail through points (n, 2) [m] at times (n,) [s]; `top_speed` [m/s] and more have the last colour."""
    at = np.arange(len(times))
    before, after = np.maximum(at - SPEED_SPAN, 0), np.minimum(at + SPEED_SPAN, len(times) - 1)
    elapsed = np.maximum(times[after] - times[before], 1e-6)
    share = np.hypot(*(points[after] - points[before]).T) / elapsed / top_speed
    return Trail(times, points, np.minimum(share * SPEED_COLORS, SPEED_COLORS - 1).astype(int))


def speed_color(index: int) -> tuple[int, int, int]:
    """Colour of a speed by its index, from 0 for the slowest to SPEED_COLORS - 1 for the fastest."""
    red, green, blue = np.rint(speed_colors(np.array([index / (SPEED_COLORS - 1)]))[0]).astype(int).tolist()
    return red, green, blue


def background(canvas: Canvas, world: World) -> Image.Image:
    """Picture of the world."""
    image = Image.new("RGB", canvas.size, FLOOR)
    draw = ImageDraw.Draw(image)
    for corners in world.polygons:
        draw.polygon(canvas.at(corners), fill=OBSTACLE, outline=WALL)
    for x, y, r in world.circles:
        draw.ellipse(canvas.disc(np.array([x, y]), r), fill=OBSTACLE, outline=WALL)
    (left, top), (right, bottom) = canvas.at(np.array([world.bounds[0::3], world.bounds[2:0:-1]]))
    draw.rectangle([left, top, right, bottom], outline=WALL, width=(2 if world.walled else 1) * SMOOTHING)
    return image


def draw_goal(draw: ImageDraw.ImageDraw, canvas: Canvas, goal: np.ndarray, tolerance: float) -> None:
    """Draws the goal (2,) [m] and the disc of its tolerance [m]."""
    draw.ellipse(canvas.disc(goal, tolerance), outline=GOAL, width=2 * SMOOTHING)
    draw.ellipse(canvas.disc(goal, 0.2 * tolerance), fill=GOAL)


def draw_trail(draw: ImageDraw.ImageDraw, canvas: Canvas, trail: Trail, until: float) -> None:
    """Draws the trail up to the time `until` [s], coloured by speed."""
    passed = int(np.searchsorted(trail.times, until, side="right"))
    points = canvas.at(trail.points[:passed:2])
    width = round(TRAIL_WIDTH * SMOOTHING)
    for k in range(len(points) - 1):
        draw.line(points[k : k + 2], fill=speed_color(int(trail.color[2 * k])), width=width)
        draw.ellipse(box(*points[k + 1], 0.5 * width - 1), fill=speed_color(int(trail.color[2 * k])))


def draw_robot(draw: ImageDraw.ImageDraw, canvas: Canvas, position: np.ndarray, radius: float) -> None:
    """Draws the robot's disc at a position (2,) [m]."""
    draw.ellipse(canvas.disc(position, radius), fill="white", outline=ROBOT, width=2 * SMOOTHING)


def draw_marks(draw: ImageDraw.ImageDraw, canvas: Canvas, marks: Marks, now: float) -> None:
    """Draws the impacts up to the time `now` [s], new ones larger."""
    for time, point, deliberate in zip(marks.times, marks.points, marks.deliberate, strict=True):
        if time <= now:
            fresh = max(0.0, 1.0 - (now - time) / FLASH_TIME)
            ((x, y),) = canvas.at(point)
            draw_mark(draw, x, y, canvas.scale * (MARK + fresh * (FLASH - MARK)), bool(deliberate))


def draw_mark(draw: ImageDraw.ImageDraw, x: float, y: float, radius: float, deliberate: bool) -> None:
    """Draws the mark of an impact at a pixel: a diamond if it was deliberate, else a cross."""
    if deliberate:
        r = DIAMOND * radius
        draw.polygon(
            [(x - r, y), (x, y - r), (x + r, y), (x, y + r)], fill=DELIBERATE, outline=OUTLINE, width=SMOOTHING
        )
        return
    r = radius * math.sqrt(0.5)
    for color, width in ((OUTLINE, 5 * SMOOTHING), (OTHER, 3 * SMOOTHING)):
        for side in (-1, 1):
            draw.line([x - r, y - side * r, x + r, y + side * r], fill=color, width=width)


def box(x: float, y: float, radius: float) -> list[float]:
    """Bounding box of a disc in pixels, for Pillow."""
    return [x - radius, y - radius, x + radius, y + radius]
