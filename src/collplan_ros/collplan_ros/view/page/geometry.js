// Points, lines and the way from the world to the screen. Flat lists are x0, y0, x1, y1, ... in mm.

/** World in mm, y up, to the screen in CSS pixels, y down. */
export class Transform {
  constructor() {
    this.scale = 0.25;
    this.x = 0;
    this.y = 0;
    this.width = 1;
    this.height = 1;
  }

  sx(x) {
    return this.width / 2 + (x - this.x) * this.scale;
  }

  sy(y) {
    return this.height / 2 - (y - this.y) * this.scale;
  }

  /** World coordinates of a place on the screen. */
  world(px, py) {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }

  /** Zooms by a factor around a place on the screen, which stays where it is. */
  zoom(factor, px, py) {
    const [wx, wy] = this.world(px, py);
    this.scale = Math.min(20, Math.max(0.005, this.scale * factor));
    this.x = wx - (px - this.width / 2) / this.scale;
    this.y = wy + (py - this.height / 2) / this.scale;
  }

  /** Shows a rectangle whole, with a margin. */
  fit([x0, y0, x1, y1]) {
    this.x = (x0 + x1) / 2;
    this.y = (y0 + y1) / 2;
    const spare = 0.84;
    this.scale = spare * Math.min(this.width / Math.max(x1 - x0, 1), this.height / Math.max(y1 - y0, 1));
  }
}

/** The rectangle [x0, y0, x1, y1] around what is free of a world, on a coarse grid; its bounds where nothing is. */
export function freeExtent(world) {
  const { bounds } = world;
  const [x0, y0, x1, y1] = bounds;
  const cells = 60;
  const free = [Infinity, Infinity, -Infinity, -Infinity];
  for (let i = 0; i <= cells; i += 1) {
    for (let k = 0; k <= cells; k += 1) {
      const x = x0 + ((x1 - x0) * i) / cells;
      const y = y0 + ((y1 - y0) * k) / cells;
      if (isSolid(world, x, y)) continue;
      free[0] = Math.min(free[0], x);
      free[1] = Math.min(free[1], y);
      free[2] = Math.max(free[2], x);
      free[3] = Math.max(free[3], y);
    }
  }
  return free[2] > free[0] && free[3] > free[1] ? free : bounds;
}

/** Whether a point is inside of a wall, or behind those around a world that has them. */
export function isSolid({ bounds: [x0, y0, x1, y1], walled, polygons, circles }, x, y) {
  return (
    (walled && !(x0 <= x && x <= x1 && y0 <= y && y <= y1)) ||
    circles.some(([cx, cy, radius]) => Math.hypot(x - cx, y - cy) < radius) ||
    polygons.some((corners) => isInside(corners, x, y))
  );
}

/** Whether a point is in a convex polygon, counter-clockwise. */
function isInside(corners, x, y) {
  for (let i = 0; i < corners.length; i += 2) {
    const k = (i + 2) % corners.length;
    const [ax, ay] = [corners[i], corners[i + 1]];
    if ((corners[k] - ax) * (y - ay) - (corners[k + 1] - ay) * (x - ax) < 0) return false;
  }
  return true;
}

/** Adds a polyline to the path of a context. */
export function addLine(ctx, view, flat, closed = false) {
  for (let i = 0; i + 1 < flat.length; i += 2) {
    const x = view.sx(flat[i]);
    const y = view.sy(flat[i + 1]);
    if (i === 0) ctx.moveTo(x, y);
    else ctx.lineTo(x, y);
  }
  if (closed && flat.length > 2) ctx.closePath();
}

/** Adds separate lines of two points each to the path of a context. */
export function addSegments(ctx, view, flat) {
  for (let i = 0; i + 3 < flat.length; i += 4) {
    ctx.moveTo(view.sx(flat[i]), view.sy(flat[i + 1]));
    ctx.lineTo(view.sx(flat[i + 2]), view.sy(flat[i + 3]));
  }
}

/** Draws an arrow between two places on the screen. */
export function drawArrow(ctx, x0, y0, x1, y1, head) {
  const length = Math.hypot(x1 - x0, y1 - y0);
  if (length < 1) return;
  const ux = (x1 - x0) / length;
  const uy = (y1 - y0) / length;
  const size = Math.min(head, length);
  const bx = x1 - ux * size;
  const by = y1 - uy * size;
  ctx.beginPath();
  ctx.moveTo(x0, y0);
  ctx.lineTo(bx, by);
  ctx.stroke();
  ctx.beginPath();
  ctx.moveTo(x1, y1);
  ctx.lineTo(bx - uy * size * 0.55, by + ux * size * 0.55);
  ctx.lineTo(bx + uy * size * 0.55, by - ux * size * 0.55);
  ctx.closePath();
  ctx.fill();
}

/** Distance of a place from a line between two others, on the screen. */
export function distanceToSegment(px, py, x0, y0, x1, y1) {
  const dx = x1 - x0;
  const dy = y1 - y0;
  const square = dx * dx + dy * dy;
  const share = square > 0 ? Math.min(1, Math.max(0, ((px - x0) * dx + (py - y0) * dy) / square)) : 0;
  return Math.hypot(px - x0 - share * dx, py - y0 - share * dy);
}

/** The angle from -pi to pi. */
export function wrapped(angle) {
  return Math.atan2(Math.sin(angle), Math.cos(angle));
}

/** Index of the first entry of a list sorted by `t` that is after a time. */
export function firstAfter(list, time) {
  let low = 0;
  let high = list.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (list[middle].t > time) high = middle;
    else low = middle + 1;
  }
  return low;
}
