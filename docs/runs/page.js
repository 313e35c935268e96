(() => {
// Points, lines and the way from the world to the screen. Flat lists are x0, y0, x1, y1, ... in mm.

/** World in mm, y up, to the screen in CSS pixels, y down. */
class Transform {
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
function freeExtent(world) {
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
function isSolid({ bounds: [x0, y0, x1, y1], walled, polygons, circles }, x, y) {
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
function addLine(ctx, view, flat, closed = false) {
  for (let i = 0; i + 1 < flat.length; i += 2) {
    const x = view.sx(flat[i]);
    const y = view.sy(flat[i + 1]);
    if (i === 0) ctx.moveTo(x, y);
    else ctx.lineTo(x, y);
  }
  if (closed && flat.length > 2) ctx.closePath();
}

/** Adds separate lines of two points each to the path of a context. */
function addSegments(ctx, view, flat) {
  for (let i = 0; i + 3 < flat.length; i += 4) {
    ctx.moveTo(view.sx(flat[i]), view.sy(flat[i + 1]));
    ctx.lineTo(view.sx(flat[i + 2]), view.sy(flat[i + 3]));
  }
}

/** Draws an arrow between two places on the screen. */
function drawArrow(ctx, x0, y0, x1, y1, head) {
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
function distanceToSegment(px, py, x0, y0, x1, y1) {
  const dx = x1 - x0;
  const dy = y1 - y0;
  const square = dx * dx + dy * dy;
  const share = square > 0 ? Math.min(1, Math.max(0, ((px - x0) * dx + (py - y0) * dy) / square)) : 0;
  return Math.hypot(px - x0 - share * dx, py - y0 - share * dy);
}

/** The angle from -pi to pi. */
function wrapped(angle) {
  return Math.atan2(Math.sin(angle), Math.cos(angle));
}

/** Index of the first entry of a list sorted by `t` that is after a time. */
function firstAfter(list, time) {
  let low = 0;
  let high = list.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (list[middle].t > time) high = middle;
    else low = middle + 1;
  }
  return low;
}

// Elements of the page. Text that came over the network is only ever set as text.

/** The element with an id. */
const byId = (id) => document.getElementById(id);

/** A new element at the end of another. */
function element(name, parent, className = "", text = "") {
  const made = document.createElement(name);
  if (className) made.className = className;
  if (text) made.textContent = text;
  parent.append(made);
  return made;
}

/** What was kept in this browser under a name; null where it keeps nothing. */
function kept(name) {
  try {
    return JSON.parse(localStorage.getItem(`collplan.${name}`));
  } catch {
    return null;
  }
}

/** Keeps a value in this browser, where it lets one. */
function keep(name, value) {
  try {
    localStorage.setItem(`collplan.${name}`, JSON.stringify(value));
  } catch {
    // a page of a file, or a browser that keeps nothing
  }
}

// Colours that the colour-blind can tell apart (Okabe and Ito 2008), and shapes and dashes beside them.

const LIGHT = {
  back: "#e9edf2", floor: "#ffffff", solid: "#c9d1db", edge: "#46566b", grid: "#eef1f5", text: "#1b2633",
  muted: "#66758a", free: "rgba(0,158,115,0.13)", freeEdge: "#009e73", frontier: "#0072b2", predicted: "#6a3d9a",
  remembered: "#5b6675", inferred: "rgba(70,86,107,0.16)", scan: "#d0175f", contact: "#d55e00",
  robot: "#222c3a", ring: "#e69f00", heading: "#ffffff", goal: "#00855f", deliberate: "#d55e00",
  mover: "#56708f", found: "#cc79a7", foreseen: "#e69f00", other: "#111111", outline: "#ffffff", plotLine: "#0072b2", plotGrid: "#dde3ea",
};
const DARK = {
  back: "#0b0f14", floor: "#151b23", solid: "#303b49", edge: "#8898ad", grid: "#1d252f", text: "#e4ebf3",
  muted: "#8e9db0", free: "rgba(0,190,140,0.14)", freeEdge: "#1fc796", frontier: "#56b4e9", predicted: "#c9a4f2",
  remembered: "#a7b4c4", inferred: "rgba(167,180,196,0.16)", scan: "#ff5c93", contact: "#ff8a3c",
  robot: "#0a0e13", ring: "#f5b52e", heading: "#ffffff", goal: "#2fd6a2", deliberate: "#ff8a3c",
  mover: "#9fd4ff", found: "#e8a3c8", foreseen: "#f5b52e", other: "#ffffff", outline: "#0b0f14", plotLine: "#56b4e9", plotGrid: "#29333f",
};
const TERM_LIGHT = ["#111111", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b8860b", "#56b4e9", "#6a3d9a"];
const TERM_DARK = ["#ffffff", "#56b4e9", "#ff8a3c", "#1fc796", "#e8a3c8", "#f0e442", "#9fd4ff", "#c9a4f2"];
// plasma: its lightness rises all the way, so that it is read without colours too
const SPEED = ["#0d0887", "#5c01a6", "#9c179e", "#cc4778", "#ed7953", "#fdb42f", "#f0f921"];
const COST_LIGHT = ["#08306b", "#2171b5", "#6baed6", "#c6dbef"];
const COST_DARK = ["#e6f3ff", "#7fbdf0", "#3d7fb5", "#1d3f5e"];

const numbers = new Map();

function channels(color) {
  if (!numbers.has(color)) numbers.set(color, [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16)));
  return numbers.get(color);
}

function ramp(stops, share) {
  const at = Math.min(0.9999, Math.max(0, Number.isFinite(share) ? share : 0)) * (stops.length - 1);
  const low = Math.floor(at);
  const [a, b] = [channels(stops[low]), channels(stops[low + 1])];
  return `rgb(${a.map((value, i) => Math.round(value + (at - low) * (b[i] - value))).join(",")})`;
}

/** The colours of a theme. */
class Colors {
  constructor(dark) {
    Object.assign(this, dark ? DARK : LIGHT);
    this.dark = dark;
    this.terms = dark ? TERM_DARK : TERM_LIGHT;
  }

  /** Colour of a speed as a share of the highest; its dark end is not used on dark ground, nor its light one on light. */
  speed(share) {
    const clipped = Math.min(1, Math.max(0, share));
    return ramp(SPEED, this.dark ? 0.22 + 0.78 * clipped : 0.86 * clipped);
  }

  /** Colour of a cost by its rank, from the cheapest at 0 to the dearest at 1. */
  cost(share) {
    return ramp(this.dark ? COST_DARK : COST_LIGHT, share);
  }
}

// What the page knows: the newest of each part of the frames, the way of the robot, and what is plotted.


const KEPT = 60; // s of way and plots
const STEP_BACK = 0.5; // s: a frame that is so much earlier begins another time
const RESTED = 0.5; // s for which a robot at rest has to have been there
const REST_SPEED = 150; // mm/s: the noise of the velocity measured is less, but for rare ones
const REST_DRIFT = 5; // mm from the one half of that time to the other
const MOST_QUEUED = 60; // frames: a page that was hidden does not replay what it missed

/** Frames in, their state at a time out. */
class Scene {
  constructor() {
    this.reset();
  }

  /** Forgets everything. */
  reset() {
    this.parts = {};
    this.queue = [];
    this.newest = -Infinity;
    this.version = (this.version ?? 0) + 1;
    this.forgetWay();
  }

  /** Forgets where the robot was and what is plotted. */
  forgetWay() {
    this.track = [];
    this.refused = [];
    this.series = { planning: [], period: [], distance: [], terms: new Map() };
  }

  /** Takes the next frame; it counts from its time on. */
  push(frame) {
    if (frame.t < this.newest - STEP_BACK) {
      this.queue.splice(0).forEach((earlier) => this.apply(earlier));
      this.newest = frame.t;
      this.forgetWay();
    }
    this.newest = Math.max(this.newest, frame.t);
    if (frame.history) {
      this.forgetWay();
      frame.history.forEach((earlier) => this.takeWay(earlier));
      frame.history.forEach((earlier) => this.takeFigures(earlier, frame.goal));
    }
    this.takeWay(frame);
    this.queue.push(frame);
    while (this.queue.length > MOST_QUEUED) this.apply(this.queue.shift());
  }

  /** Applies the frames up to a time; whether there were any. */
  advance(time) {
    let changed = false;
    while (this.queue.length && this.queue[0].t <= time) {
      this.apply(this.queue.shift());
      changed = true;
    }
    return changed;
  }

  apply(frame) {
    for (const [name, part] of Object.entries(frame)) {
      if (name !== "history" && name !== "t") this.parts[name] = part;
    }
    this.takeFigures(frame);
    this.version += 1;
  }

  /** Adds where the robot was; ahead of its time, so that its motion between two frames is known. */
  takeWay(frame) {
    const last = this.track.length ? this.track[this.track.length - 1].t : -Infinity;
    const between = frame.trail ?? [];
    for (let i = 0; i + 2 < between.length; i += 3) {
      const t = frame.t - between[i] / 1000;
      if (t > last) this.track.push({ t, x: between[i + 1], y: between[i + 2], yaw: null, speed: null });
    }
    if (frame.robot && frame.t > last) {
      const [x, y, yaw, vx, vy] = frame.robot;
      const measured = Math.hypot(vx, vy);
      this.track.push({ t: frame.t, x, y, yaw: yaw / 1000, vx, vy, speed: measured });
      if (measured < REST_SPEED && this.rests(frame.t)) this.track.at(-1).speed = 0;
      this.fillIn();
    }
    this.refused.push(...(frame.refused ?? []).map(([x, y, scan]) => ({ t: frame.t, x, y, scan })));
    for (const list of [this.track, this.refused]) {
      const keep = firstAfter(list, frame.t - KEPT);
      if (keep > 200) list.splice(0, keep);
    }
  }

  /** Whether the robot has not moved in the time before `t`, beyond the noise of its poses. */
  rests(t) {
    const begin = firstAfter(this.track, t - RESTED);
    const middle = firstAfter(this.track, t - RESTED / 2);
    if (begin === 0 || middle === begin) return false;
    const mean = (rows, axis) => rows.reduce((sum, row) => sum + row[axis], 0) / rows.length;
    const [before, after] = [this.track.slice(begin, middle), this.track.slice(middle)];
    return Math.hypot(mean(after, "x") - mean(before, "x"), mean(after, "y") - mean(before, "y")) < REST_DRIFT;
  }

  /** Gives the poses between the last two whole ones their heading and speed. */
  fillIn() {
    const end = this.track.length - 1;
    let begin = end - 1;
    while (begin >= 0 && this.track[begin].yaw === null) begin -= 1;
    const b = this.track[end];
    const a = begin >= 0 ? this.track[begin] : b;
    for (let i = begin + 1; i < end; i += 1) {
      const share = b.t > a.t ? (this.track[i].t - a.t) / (b.t - a.t) : 1;
      this.track[i].yaw = a.yaw + share * wrapped(b.yaw - a.yaw);
      this.track[i].speed = a.speed + share * (b.speed - a.speed);
    }
  }

  takeFigures(frame, goal = frame.goal ?? this.parts.goal) {
    const { planning, period, distance, terms } = this.series;
    const t = frame.t;
    if (frame.costs) {
      planning.push({ t, value: frame.costs.planning_time });
      for (const [name, value] of Object.entries(frame.costs.terms)) {
        if (!terms.has(name)) terms.set(name, []);
        terms.get(name).push({ t, value });
      }
    }
    if (frame.periods?.length) period.push({ t, value: Math.max(...frame.periods) });
    if (frame.robot && goal?.at) {
      distance.push({ t, value: Math.hypot(frame.robot[0] - goal.at[0], frame.robot[1] - goal.at[1]) / 1000 });
    }
    for (const list of [planning, period, distance, ...terms.values()]) {
      const keep = firstAfter(list, t - KEPT);
      if (keep > 100) list.splice(0, keep);
    }
  }

  /** The robot at a time, between the poses before and after; null where there is none. */
  robotAt(time) {
    if (!this.track.length) return null;
    const after = firstAfter(this.track, time);
    const b = this.track[Math.min(after, this.track.length - 1)];
    const a = this.track[Math.max(0, Math.min(after, this.track.length) - 1)];
    const share = b.t > a.t ? Math.min(1, Math.max(0, (time - a.t) / (b.t - a.t))) : 1;
    const yaw = (a.yaw ?? 0) + share * wrapped((b.yaw ?? 0) - (a.yaw ?? 0));
    const speed = (a.speed ?? 0) + share * ((b.speed ?? 0) - (a.speed ?? 0));
    return { x: a.x + share * (b.x - a.x), y: a.y + share * (b.y - a.y), yaw, speed, age: Math.max(0, time - b.t) };
  }

  /** Whether the robot is on the way to a goal. */
  get active() {
    return ["accepted", "executing"].includes(this.parts.goal?.status);
  }
}

// What is drawn, layer by layer, from the ground up. A layer draws itself, and a small sample of itself for the list.


const TRAIL_SHOWN = 15; // s
const SMOOTH = 0.025; // s to either side
const FLASH = 0.7; // s for which an impact is seen to happen
const AFTER = 0.22; // s of the velocity after a contact that its arrow is long
const AHEAD = 0.5; // s of the velocity of what moves that its arrow is long
const MOVED_ON = 0.3; // s for which what moves is drawn on from where it was
const SPEED_STEPS = 24; // colours that lines by speed are drawn in

/** A picture at a moment: context, transform, colours, the scene, and the time. */
class Picture {
  constructor(ctx, view, colors, scene, now) {
    Object.assign(this, { ctx, view, colors, scene, now });
    this.about = scene.parts.about ?? {};
    this.radius = this.about.radius ?? 90;
    this.fastest = this.about.max_speed ?? 1200;
  }

  get parts() {
    return this.scene.parts;
  }

  stroke(color, width, dash = []) {
    this.ctx.strokeStyle = color;
    this.ctx.lineWidth = width;
    this.ctx.setLineDash(dash);
  }

  circle(x, y, radius) {
    this.ctx.beginPath();
    this.ctx.arc(this.view.sx(x), this.view.sy(y), Math.max(0.5, radius), 0, 2 * Math.PI);
  }
}

/** Ground, walls and grid: always there. */
function drawGround(picture) {
  const { ctx, view, colors, parts } = picture;
  ctx.setLineDash([]);
  ctx.fillStyle = parts.world ? colors.back : colors.floor;
  ctx.fillRect(0, 0, view.width, view.height);
  if (parts.world) {
    const [x0, y0, x1, y1] = parts.world.bounds;
    ctx.fillStyle = colors.floor;
    ctx.fillRect(view.sx(x0), view.sy(y1), (x1 - x0) * view.scale, (y1 - y0) * view.scale);
  }
  drawGrid(picture);
}

function drawGrid({ ctx, view, colors, parts }) {
  const step = [50, 100, 200, 500, 1000, 2000, 5000, 10000].find((each) => each * view.scale > 48) ?? 20000;
  const [left, top] = view.world(0, 0);
  const [right, bottom] = view.world(view.width, view.height);
  const [x0, y0, x1, y1] = parts.world?.bounds ?? [left, bottom, right, top];
  ctx.beginPath();
  for (let x = Math.ceil(Math.max(left, x0) / step) * step; x <= Math.min(right, x1); x += step) {
    ctx.moveTo(view.sx(x), view.sy(Math.max(bottom, y0)));
    ctx.lineTo(view.sx(x), view.sy(Math.min(top, y1)));
  }
  for (let y = Math.ceil(Math.max(bottom, y0) / step) * step; y <= Math.min(top, y1); y += step) {
    ctx.moveTo(view.sx(Math.max(left, x0)), view.sy(y));
    ctx.lineTo(view.sx(Math.min(right, x1)), view.sy(y));
  }
  ctx.strokeStyle = colors.grid;
  ctx.lineWidth = 1;
  ctx.stroke();
}

/** The scale of the picture, in its corner. */
function drawScale({ ctx, view, colors }) {
  const length = [50, 100, 200, 500, 1000, 2000, 5000].find((each) => each * view.scale > 60) ?? 10000;
  const [x, y] = [14, view.height - 16];
  ctx.setLineDash([]);
  ctx.strokeStyle = colors.muted;
  ctx.lineWidth = 2;
  ctx.beginPath();
  ctx.moveTo(x, y - 4);
  ctx.lineTo(x, y);
  ctx.lineTo(x + length * view.scale, y);
  ctx.lineTo(x + length * view.scale, y - 4);
  ctx.stroke();
  ctx.fillStyle = colors.muted;
  ctx.font = "12px system-ui, sans-serif";
  ctx.fillText(length < 1000 ? `${length / 10} cm` : `${length / 1000} m`, x + 4, y - 7);
}

function drawWalls({ ctx, view, colors, parts }) {
  const world = parts.world;
  if (!world) return;
  const outlines = () => {
    world.polygons.forEach((corners) => addLine(ctx, view, corners, true));
    for (const [x, y, radius] of world.circles) {
      ctx.moveTo(view.sx(x + radius), view.sy(y));
      ctx.arc(view.sx(x), view.sy(y), radius * view.scale, 0, 2 * Math.PI);
    }
  };
  const [x0, y0, x1, y1] = world.bounds;
  const rim = 0.025 * Math.max(x1 - x0, y1 - y0) * view.scale;
  const [left, top, width, height] = [view.sx(x0), view.sy(y1), (x1 - x0) * view.scale, (y1 - y0) * view.scale];
  // outlines first and the ground over their inner half: pieces that touch show no seam
  ctx.strokeStyle = colors.edge;
  ctx.fillStyle = colors.solid;
  ctx.lineWidth = 6;
  if (world.walled) ctx.strokeRect(left, top, width, height);
  ctx.lineWidth = 4;
  ctx.beginPath();
  outlines();
  ctx.stroke();
  if (world.walled) {
    // a pixel more than the rim is wide, over which it meets the obstacles
    ctx.beginPath();
    ctx.rect(left - rim, top - rim, width + 2 * rim, height + 2 * rim);
    ctx.rect(left + 1, top + 1, width - 2, height - 2);
    ctx.fill("evenodd");
  }
  ctx.beginPath();
  outlines();
  ctx.fill("nonzero");
}

function drawFree({ ctx, view, colors, parts }) {
  if (!parts.free?.length) return;
  ctx.beginPath();
  addLine(ctx, view, parts.free, true);
  ctx.fillStyle = colors.free;
  ctx.fill();
  ctx.strokeStyle = colors.freeEdge;
  ctx.lineWidth = 1.5;
  ctx.stroke();
}

function drawInferred(picture) {
  const { ctx, view, colors, parts, about } = picture;
  if (!parts.inferred?.length) return;
  picture.stroke(colors.inferred, Math.max(1, (about.spacing ?? 20) * view.scale));
  ctx.lineCap = "butt";
  ctx.beginPath();
  addSegments(ctx, view, parts.inferred);
  ctx.stroke();
}

function drawRemembered(picture) {
  const { ctx, view, colors, parts } = picture;
  if (!parts.remembered?.length) return;
  picture.stroke(colors.remembered, 2.5);
  ctx.beginPath();
  addSegments(ctx, view, parts.remembered);
  ctx.stroke();
}

function drawFrontiers(picture) {
  const { ctx, view, colors, parts } = picture;
  if (!parts.frontiers?.length) return;
  picture.stroke(colors.frontier, 3, [7, 5]);
  ctx.beginPath();
  addSegments(ctx, view, parts.frontiers);
  ctx.stroke();
}

function drawPredicted(picture) {
  const { ctx, view, colors, parts } = picture;
  const flat = parts.predicted ?? [];
  picture.stroke(colors.predicted, 2);
  ctx.fillStyle = colors.predicted;
  for (let i = 0; i + 3 < flat.length; i += 4) {
    drawArrow(ctx, view.sx(flat[i]), view.sy(flat[i + 1]), view.sx(flat[i + 2]), view.sy(flat[i + 3]), 9);
  }
}

function drawScan({ ctx, view, colors, parts }) {
  const flat = parts.scan ?? [];
  const size = Math.min(3.5, Math.max(1.3, 6 * view.scale));
  ctx.fillStyle = parts.refuses ? colors.other : colors.scan;
  ctx.beginPath();
  for (let i = 0; i + 1 < flat.length; i += 2) {
    const x = view.sx(flat[i]);
    const y = view.sy(flat[i + 1]);
    ctx.moveTo(x + size, y);
    ctx.arc(x, y, size, 0, 2 * Math.PI);
  }
  ctx.fill();
}

/** Share of each cost by its rank, from the cheapest at 0 to the dearest at 1. */
function ranks(costs) {
  const order = costs.map((_, i) => i).sort((a, b) => costs[a] - costs[b]);
  const shares = new Array(costs.length);
  order.forEach((which, rank) => (shares[which] = costs.length > 1 ? rank / (costs.length - 1) : 0));
  return shares;
}

function drawCandidates(picture) {
  const { ctx, view, colors, parts } = picture;
  const at = parts.candidates?.at ?? [];
  if (!at.length) return;
  const shares = ranks(parts.candidates.terms.total ?? []);
  picture.stroke("", 1.6);
  for (let k = shares.length - 1; k >= 0; k -= 1) {
    const color = colors.cost(shares[k]);
    const [x, y] = [view.sx(at[4 * k]), view.sy(at[4 * k + 1])];
    ctx.strokeStyle = color;
    ctx.fillStyle = color;
    ctx.beginPath();
    ctx.moveTo(x, y);
    ctx.lineTo(x + 0.1 * at[4 * k + 2] * view.scale, y - 0.1 * at[4 * k + 3] * view.scale);
    ctx.stroke();
    ctx.beginPath();
    ctx.arc(x, y, 2.2, 0, 2 * Math.PI);
    ctx.fill();
  }
}

function drawRollouts(picture) {
  const { ctx, view, colors, parts } = picture;
  const rollouts = parts.rollouts ?? [];
  for (let k = rollouts.length - 1; k >= 0; k -= 1) {
    picture.stroke(colors.cost(rollouts.length > 1 ? (0.85 * k) / (rollouts.length - 1) : 0), k ? 1.3 : 2);
    ctx.globalAlpha = k ? 0.8 : 1;
    ctx.beginPath();
    addLine(ctx, view, rollouts[k].path);
    ctx.stroke();
  }
  ctx.globalAlpha = 1;
}

/** Draws lines between points {x, y, speed} on the screen, coloured by speed, in few strokes. */
function drawBySpeed(picture, points, width, alphaOf = null) {
  const { ctx, colors, fastest } = picture;
  ctx.lineJoin = "round";
  // ends of what shines through would be seen twice where they overlap
  ctx.lineCap = alphaOf ? "butt" : "round";
  picture.stroke("", width);
  const stepOf = (point) => Math.round((SPEED_STEPS * Math.min(point.speed, fastest)) / fastest);
  let begin = 0;
  while (begin < points.length - 1) {
    const step = stepOf(points[begin + 1]);
    let end = begin + 1;
    while (end < points.length - 1 && stepOf(points[end + 1]) === step && (!alphaOf || end - begin < 12)) end += 1;
    ctx.strokeStyle = colors.speed(step / SPEED_STEPS);
    ctx.globalAlpha = alphaOf ? alphaOf(points[end]) : 1;
    ctx.beginPath();
    ctx.moveTo(points[begin].x, points[begin].y);
    for (let i = begin + 1; i <= end; i += 1) ctx.lineTo(points[i].x, points[i].y);
    ctx.stroke();
    begin = end;
  }
  ctx.globalAlpha = 1;
  ctx.lineCap = "butt";
}

function drawTrail(picture) {
  const { view, scene, now } = picture;
  const points = [];
  const end = firstAfter(scene.track, now);
  for (let i = firstAfter(scene.track, now - TRAIL_SHOWN); i < end; i += 1) {
    const { t, x, y, speed } = scene.track[i];
    points.push({ t, x: view.sx(x), y: view.sy(y), speed: speed ?? 0 });
  }
  const robot = scene.robotAt(now);
  if (robot) points.push({ t: now, x: view.sx(robot.x), y: view.sy(robot.y), speed: robot.speed });
  drawBySpeed(picture, smoothed(points), 2.5, (point) => Math.max(0.12, 1 - (now - point.t) / TRAIL_SHOWN));
  drawRefused(picture);
}

/** Where poses were refused, and where the robot was at scans that were. */
function drawRefused({ ctx, view, colors, scene, now }) {
  const begin = firstAfter(scene.refused, now - TRAIL_SHOWN);
  ctx.fillStyle = colors.other;
  ctx.font = "14px system-ui, sans-serif";
  for (const { x, y, scan } of scene.refused.slice(begin, firstAfter(scene.refused, now))) {
    ctx.fillText(scan ? "□" : "✕", view.sx(x) - 5, view.sy(y) + 5);
  }
}

/** Each point amid those within SMOOTH of it: what is measured trembles. */
function smoothed(points) {
  let [begin, end, x, y] = [0, 0, 0, 0];
  return points.map((point) => {
    for (; end < points.length && points[end].t <= point.t + SMOOTH; end += 1) [x, y] = [x + points[end].x, y + points[end].y];
    for (; points[begin].t < point.t - SMOOTH; begin += 1) [x, y] = [x - points[begin].x, y - points[begin].y];
    return { ...point, x: x / (end - begin), y: y / (end - begin) };
  });
}

/** The plan's points that are still to come, on the screen, with the speed to each. */
function planAhead({ view, parts, now }) {
  const { path, times, stamp } = parts.plan;
  const points = [];
  const since = 1000 * (now - stamp);
  for (let k = 0; k < times.length; k += 1) {
    const [x, y] = [path[2 * k], path[2 * k + 1]];
    let speed = 0;
    if (k) {
      const time = Math.max(1, times[k] - times[k - 1]);
      speed = (1000 * Math.hypot(x - path[2 * k - 2], y - path[2 * k - 1])) / time;
    }
    if (times[k] >= since || k === times.length - 1) points.push({ x: view.sx(x), y: view.sy(y), speed });
  }
  return points;
}

function drawPlan(picture) {
  const { ctx, view, colors, parts, scene, now } = picture;
  if (!parts.plan) return;
  const points = planAhead(picture);
  const robot = scene.robotAt(now);
  if (robot && points.length) points.unshift({ x: view.sx(robot.x), y: view.sy(robot.y), speed: robot.speed });
  // an outline, so that it stands out of the fan
  picture.stroke(colors.outline, 7);
  ctx.lineJoin = "round";
  ctx.globalAlpha = 0.75;
  ctx.beginPath();
  points.forEach((point, k) => (k ? ctx.lineTo(point.x, point.y) : ctx.moveTo(point.x, point.y)));
  ctx.stroke();
  ctx.globalAlpha = 1;
  drawBySpeed(picture, points, 4.5);
}

/** Where the plan has the robot's centre so many ms after its stamp. */
function centreAt({ path, times }, ms) {
  let k = times.findIndex((time) => time >= ms);
  if (k < 0) k = times.length - 1;
  const before = Math.max(0, k - 1);
  const share = times[k] > times[before] ? (ms - times[before]) / (times[k] - times[before]) : 0;
  return [0, 1].map((i) => path[2 * before + i] + share * (path[2 * k + i] - path[2 * before + i]));
}

/** The contacts of the plan that are still to come: point, velocity after, ms after the plan's stamp. */
function contactsAhead({ parts, now }) {
  const contacts = parts.plan?.contacts ?? [];
  const found = [];
  for (let i = 0; i + 4 < contacts.length; i += 5) {
    const [x, y, vx, vy, ms] = contacts.slice(i, i + 5);
    if (parts.plan.stamp + ms / 1000 >= now - 0.05) found.push({ x, y, vx, vy, ms });
  }
  return found;
}

function drawContacts(picture) {
  const { ctx, view, colors, parts, radius } = picture;
  for (const { x, y, vx, vy, ms } of contactsAhead(picture)) {
    const [cx, cy] = centreAt(parts.plan, ms);
    picture.stroke(colors.contact, 1.6, [4, 3]);
    picture.circle(cx, cy, radius * view.scale);
    ctx.stroke();
    picture.stroke(colors.contact, 3);
    ctx.fillStyle = colors.contact;
    const [sx, sy] = [view.sx(x), view.sy(y)];
    drawArrow(ctx, sx, sy, sx + AFTER * vx * view.scale, sy - AFTER * vy * view.scale, 13);
    picture.circle(x, y, 5);
    ctx.fill();
  }
}

function drawGoal(picture) {
  const { ctx, view, colors, parts, about } = picture;
  if (!parts.goal?.at || parts.goal.status === "none") return;
  const [x, y] = parts.goal.at;
  const ended = !picture.scene.active;
  ctx.globalAlpha = ended ? 0.45 : 1;
  picture.stroke(colors.goal, 2.5, ended ? [5, 4] : []);
  picture.circle(x, y, (about.tolerance ?? 100) * view.scale);
  ctx.stroke();
  ctx.fillStyle = colors.goal;
  ctx.globalAlpha = ended ? 0.1 : 0.2;
  ctx.fill();
  ctx.globalAlpha = ended ? 0.45 : 1;
  picture.circle(x, y, 4);
  ctx.fill();
  ctx.globalAlpha = 1;
}

/** Discs of what moves, where they are by now, and an arrow of the velocity of each. */
function drawMovers(picture, part, color, dash) {
  const { ctx, view, now } = picture;
  const at = part?.at ?? [];
  const later = Math.min(MOVED_ON, Math.max(-MOVED_ON, now - (part?.stamp ?? now)));
  ctx.fillStyle = color;
  for (let i = 0; i + 4 < at.length; i += 5) {
    const [x, y, vx, vy, radius] = at.slice(i, i + 5);
    const [cx, cy] = [x + later * vx, y + later * vy];
    picture.stroke(color, 2, dash);
    picture.circle(cx, cy, radius * view.scale);
    ctx.stroke();
    ctx.globalAlpha = 0.2;
    ctx.fill();
    ctx.globalAlpha = 1;
    ctx.setLineDash([]);
    const [sx, sy] = [view.sx(cx), view.sy(cy)];
    drawArrow(ctx, sx, sy, sx + AHEAD * vx * view.scale, sy - AHEAD * vy * view.scale, 10);
  }
}

/** The sign of an impact by its kind: a diamond, a disc or a cross. */
function drawSign(ctx, colors, kind, x, y, size) {
  ctx.beginPath();
  if (kind === "deliberate") {
    ctx.moveTo(x, y - 1.3 * size);
    ctx.lineTo(x + 1.3 * size, y);
    ctx.lineTo(x, y + 1.3 * size);
    ctx.lineTo(x - 1.3 * size, y);
    ctx.closePath();
  } else if (kind === "foreseen") {
    ctx.arc(x, y, size, 0, 2 * Math.PI);
  } else {
    ctx.moveTo(x - size, y - size);
    ctx.lineTo(x + size, y + size);
    ctx.moveTo(x + size, y - size);
    ctx.lineTo(x - size, y + size);
    ctx.strokeStyle = colors.outline;
    ctx.lineWidth = 5;
    ctx.stroke();
    ctx.strokeStyle = colors.other;
    ctx.lineWidth = 2.5;
    ctx.stroke();
    return;
  }
  ctx.fillStyle = colors[kind];
  ctx.fill();
  ctx.strokeStyle = colors.outline;
  ctx.lineWidth = 1.5;
  ctx.stroke();
}

function drawImpacts(picture) {
  const { ctx, view, colors, parts, now } = picture;
  ctx.setLineDash([]);
  for (const { t, at, kind, speed } of parts.impacts ?? []) {
    if (t > now) continue;
    const [x, y] = [view.sx(at[0]), view.sy(at[1])];
    const age = now - t;
    if (age < FLASH) {
      const share = age / FLASH;
      picture.stroke(colors[kind], 4 * (1 - share) + 0.5);
      ctx.globalAlpha = 1 - share;
      picture.circle(at[0], at[1], 6 + (14 + 0.03 * (speed ?? 0)) * share);
      ctx.stroke();
    }
    ctx.globalAlpha = age > 30 ? 0.35 : 1;
    drawSign(ctx, colors, kind, x, y, 4.5);
    ctx.globalAlpha = 1;
  }
}

function drawRobot(picture) {
  const { ctx, view, colors, scene, now, radius } = picture;
  const robot = scene.robotAt(now);
  if (!robot) return;
  const size = Math.max(6, radius * view.scale);
  const [x, y] = [view.sx(robot.x), view.sy(robot.y)];
  ctx.globalAlpha = robot.age > 0.5 ? 0.45 : 1;
  ctx.setLineDash([]);
  ctx.beginPath();
  ctx.arc(x, y, 0.86 * size, 0, 2 * Math.PI);
  ctx.fillStyle = colors.robot;
  ctx.fill();
  ctx.strokeStyle = colors.ring;
  ctx.lineWidth = 0.24 * size;
  ctx.stroke();
  ctx.save();
  ctx.translate(x, y);
  ctx.rotate(-robot.yaw);
  ctx.beginPath();
  ctx.moveTo(0.6 * size, 0);
  ctx.lineTo(-0.38 * size, 0.36 * size);
  ctx.lineTo(-0.16 * size, 0);
  ctx.lineTo(-0.38 * size, -0.36 * size);
  ctx.closePath();
  ctx.fillStyle = colors.heading;
  ctx.fill();
  ctx.restore();
  ctx.globalAlpha = 1;
}

function strip(ctx, color, width, dash = []) {
  ctx.strokeStyle = color;
  ctx.lineWidth = width;
  ctx.setLineDash(dash);
  ctx.beginPath();
  ctx.moveTo(2, 7);
  ctx.lineTo(24, 7);
  ctx.stroke();
  ctx.setLineDash([]);
}

function bySpeed(ctx, colors, width) {
  for (let x = 2; x < 24; x += 2) {
    ctx.fillStyle = colors.speed(x / 24);
    ctx.fillRect(x, 7 - width / 2, 2, width);
  }
}

/** The layers from the ground up: what it is called, how it is drawn, a sample of it, whether it is off at first. */
const LAYERS = [
  { id: "walls", label: "walls, where known", draw: drawWalls, sample: (c, k) => strip(c, k.edge, 3) },
  {
    id: "free", label: "free space F", draw: drawFree,
    sample: (c, k) => {
      c.fillStyle = k.free;
      c.fillRect(2, 1, 22, 12);
      c.strokeStyle = k.freeEdge;
      c.strokeRect(2.5, 1.5, 21, 11);
    },
  },
  { id: "inferred", label: "inferred solid", draw: drawInferred, sample: (c, k) => strip(c, k.inferred, 10) },
  { id: "remembered", label: "remembered boundaries", draw: drawRemembered, sample: (c, k) => strip(c, k.remembered, 2.5) },
  { id: "frontiers", label: "frontiers", draw: drawFrontiers, sample: (c, k) => strip(c, k.frontier, 3, [6, 4]) },
  {
    id: "predicted", label: "predicted boundaries", draw: drawPredicted,
    sample: (c, k) => {
      c.strokeStyle = c.fillStyle = k.predicted;
      c.lineWidth = 2;
      drawArrow(c, 2, 7, 24, 7, 8);
    },
  },
  {
    id: "scan", label: "scan", draw: drawScan,
    sample: (c, k) => {
      c.fillStyle = k.scan;
      for (let x = 4; x < 24; x += 6) c.fillRect(x, 5, 3, 3);
    },
  },
  {
    id: "candidates", label: "candidates by cost", draw: drawCandidates,
    sample: (c, k) => {
      for (let i = 0; i < 4; i += 1) {
        c.fillStyle = k.cost(i / 3);
        c.beginPath();
        c.arc(4 + 6 * i, 7, 2.5, 0, 7);
        c.fill();
      }
    },
  },
  {
    id: "rollouts", label: "rollouts by cost", draw: drawRollouts,
    sample: (c, k) => {
      for (let i = 0; i < 4; i += 1) {
        c.strokeStyle = k.cost(i / 3);
        c.lineWidth = 1.5;
        c.beginPath();
        c.moveTo(2, 13);
        c.quadraticCurveTo(8 + 3 * i, 1 + 3 * i, 24, 1 + 3 * i);
        c.stroke();
      }
    },
  },
  { id: "trail", label: "way of the robot, by speed; ✕ pose, □ scan refused", draw: drawTrail, sample: (c, k) => bySpeed(c, k, 2.5) },
  { id: "plan", label: "plan, by speed", draw: drawPlan, sample: (c, k) => bySpeed(c, k, 5) },
  {
    id: "contacts", label: "foreseen contacts, direction after", draw: drawContacts,
    sample: (c, k) => {
      c.strokeStyle = c.fillStyle = k.contact;
      c.lineWidth = 2.5;
      drawArrow(c, 5, 11, 22, 2, 8);
      c.beginPath();
      c.arc(5, 11, 2.5, 0, 7);
      c.fill();
    },
  },
  {
    id: "goal", label: "goal and its tolerance", draw: drawGoal,
    sample: (c, k) => {
      c.strokeStyle = k.goal;
      c.lineWidth = 2;
      c.beginPath();
      c.arc(13, 7, 5.5, 0, 7);
      c.stroke();
    },
  },
  {
    id: "movers", label: "what moves: true, and found by the planner",
    draw: (picture) => {
      drawMovers(picture, picture.parts.movers, picture.colors.mover, []);
      drawMovers(picture, picture.parts.found, picture.colors.found, [5, 4]);
    },
    sample: (c, k) => {
      for (const [color, x, dash] of [[k.mover, 7, []], [k.found, 19, [3, 2]]]) {
        c.strokeStyle = color;
        c.lineWidth = 2;
        c.setLineDash(dash);
        c.beginPath();
        c.arc(x, 7, 4.5, 0, 7);
        c.stroke();
      }
      c.setLineDash([]);
    },
  },
  {
    id: "impacts", label: "impacts: ◆ deliberate, ● foreseen, ✕ other", draw: drawImpacts,
    sample: (c, k) => {
      drawSign(c, k, "deliberate", 5, 7, 3.3);
      drawSign(c, k, "foreseen", 13, 7, 3.5);
      drawSign(c, k, "other", 21, 7, 3);
    },
  },
  {
    id: "robot", label: "robot, its ring and heading", draw: drawRobot,
    sample: (c, k) => {
      c.beginPath();
      c.arc(13, 7, 5, 0, 7);
      c.fillStyle = k.robot;
      c.fill();
      c.strokeStyle = k.ring;
      c.lineWidth = 2;
      c.stroke();
    },
  },
];

// The picture: what is in sight, what is pointed at, and where a click was.


const CLICK = 5; // px: a pointer that moved less has clicked
const NEAR = 12; // px within which something is pointed at

/** The canvas of the scene. `onclick(x, y)` is called with the place in mm, where it is set. */
class SceneCanvas {
  constructor(canvas, scene) {
    this.canvas = canvas;
    this.ctx = canvas.getContext("2d");
    this.scene = scene;
    this.view = new Transform();
    this.colors = null;
    this.onclick = null;
    this.onhover = null;
    this.following = false;
    this.beside = []; // pictures that show the same place
    this.fitted = null; // the world that was fitted, or true for the robot's surroundings
    this.moved = false;
    this.pointer = null;
    this.drag = null;
    this.stale = true;
    this.drawn = {};
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
    this.listen();
  }

  resize() {
    const ratio = window.devicePixelRatio || 1;
    const { width, height } = this.canvas.getBoundingClientRect();
    this.view.width = Math.max(1, width);
    this.view.height = Math.max(1, height);
    this.canvas.width = Math.round(this.view.width * ratio);
    this.canvas.height = Math.round(this.view.height * ratio);
    this.ratio = ratio;
    this.stale = true;
    this.fitted = null;
  }

  listen() {
    const canvas = this.canvas;
    const place = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const step = event.deltaMode === 1 ? 16 * event.deltaY : event.deltaY;
      this.zoom(Math.exp(-0.0015 * step), ...place(event));
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      canvas.setPointerCapture(event.pointerId);
      const [x, y] = place(event);
      this.drag = { x, y, wx: this.view.x, wy: this.view.y, far: false };
    });
    canvas.addEventListener("pointermove", (event) => {
      this.pointer = place(event);
      if (this.drag) this.dragTo(...this.pointer);
      this.stale = true;
    });
    canvas.addEventListener("pointerup", (event) => {
      const drag = this.drag;
      this.drag = null;
      canvas.classList.remove("dragged");
      if (drag && !drag.far && this.onclick) this.onclick(...this.view.world(...place(event)));
    });
    canvas.addEventListener("pointercancel", () => (this.drag = null));
    canvas.addEventListener("pointerleave", () => {
      this.pointer = null;
      this.stale = true;
    });
  }

  dragTo(x, y) {
    const { drag, view } = this;
    drag.far = drag.far || Math.hypot(x - drag.x, y - drag.y) > CLICK;
    if (!drag.far) return;
    this.canvas.classList.add("dragged");
    this.moved = true;
    this.following = false;
    view.x = drag.wx - (x - drag.x) / view.scale;
    view.y = drag.wy + (y - drag.y) / view.scale;
    this.share();
  }

  zoom(factor, x = this.view.width / 2, y = this.view.height / 2) {
    this.view.zoom(factor, x, y);
    this.moved = true;
    this.stale = true;
    this.share();
  }

  /** Shows the same place, as large, in the pictures beside it. */
  share() {
    const { moved, following, view: { x, y, scale } } = this;
    for (const each of this.beside) {
      Object.assign(each, { moved, following, stale: true });
      Object.assign(each.view, { x, y, scale });
    }
  }

  fit() {
    this.moved = false;
    this.following = false;
    this.fitted = null;
    this.stale = true;
  }

  /** Draws the scene at a time, where something has changed since. */
  draw(now) {
    const robot = this.scene.robotAt(now);
    this.look(robot);
    const state = `${this.scene.version} ${robot?.x} ${robot?.y} ${robot?.yaw} ${robot?.age > 0.5} ${this.flashing(now)}`;
    if (!this.stale && state === this.state) return;
    this.stale = false;
    this.state = state;
    const { ctx, view } = this;
    ctx.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    const picture = new Picture(ctx, view, this.colors, this.scene, now);
    drawGround(picture);
    for (const layer of LAYERS) if (!this.hidden.has(layer.id)) layer.draw(picture);
    drawScale(picture);
    if (this.onhover) this.onhover(this.pointer && !this.drag ? this.pointedAt(picture) : null, this.pointer);
  }

  flashing(now) {
    const last = this.scene.parts.impacts?.at(-1);
    return last && now - last.t < 0.75 && now > last.t ? now : 0;
  }

  /** Stays with the robot, or shows the world whole once it is known, until a user moves the picture. */
  look(robot) {
    const { view, scene, moved } = this;
    const { world } = scene.parts;
    if (this.following && robot) {
      view.x = robot.x;
      view.y = robot.y;
    } else if (!moved && (world ?? robot) && this.fitted !== (world ?? true)) {
      view.fit(world ? freeExtent(world) : [robot.x - 1500, robot.y - 1500, robot.x + 1500, robot.y + 1500]);
      this.fitted = world ?? true;
      this.stale = true;
    }
  }

  /** What is pointed at: a title and rows of name and value; null where it is nothing. */
  pointedAt(picture) {
    const shown = (id) => !this.hidden.has(id);
    return (
      (shown("impacts") && this.impactAt()) ||
      (shown("contacts") && this.contactAt(picture)) ||
      (shown("candidates") && this.candidateAt()) ||
      (shown("rollouts") && this.rolloutAt()) ||
      null
    );
  }

  near(x, y) {
    return Math.hypot(this.view.sx(x) - this.pointer[0], this.view.sy(y) - this.pointer[1]);
  }

  impactAt() {
    const found = (this.scene.parts.impacts ?? []).filter(({ at }) => this.near(...at) < NEAR).at(-1);
    if (!found) return null;
    const rows = [["into the wall", `${(found.speed / 1000).toFixed(2)} m/s`], ["at", `${found.t.toFixed(2)} s`]];
    return { title: `impact, ${found.kind}`, rows };
  }

  contactAt(picture) {
    const found = contactsAhead(picture).find(({ x, y }) => this.near(x, y) < NEAR);
    if (!found) return null;
    const wait = this.scene.parts.plan.stamp + found.ms / 1000 - picture.now;
    const after = Math.hypot(found.vx, found.vy) / 1000;
    return { title: "foreseen contact", rows: [["in", `${wait.toFixed(2)} s`], ["speed after", `${after.toFixed(2)} m/s`]] };
  }

  candidateAt() {
    const { at, terms } = this.scene.parts.candidates ?? { at: [] };
    let best = NEAR;
    let which = -1;
    for (let k = 0; 4 * k < at.length; k += 1) {
      const [x, y] = [at[4 * k], at[4 * k + 1]];
      const tip = this.near(x + 0.1 * at[4 * k + 2], y + 0.1 * at[4 * k + 3]);
      const distance = Math.min(tip, this.near(x, y) + 2);
      if (distance < best) [best, which] = [distance, k];
    }
    if (which < 0) return null;
    const speed = Math.hypot(at[4 * which + 2], at[4 * which + 3]) / 1000;
    const rows = Object.entries(terms).map(([name, values]) => [name.replaceAll("_", " "), String(values[which])]);
    return { title: `candidate at ${speed.toFixed(2)} m/s`, rows };
  }

  rolloutAt() {
    const rollouts = this.scene.parts.rollouts ?? [];
    let best = 8;
    let which = -1;
    rollouts.forEach(({ path }, k) => {
      for (let i = 0; i + 3 < path.length; i += 2) {
        const ends = [path[i], path[i + 2]].map((x) => this.view.sx(x));
        const heights = [path[i + 1], path[i + 3]].map((y) => this.view.sy(y));
        const distance = distanceToSegment(...this.pointer, ends[0], heights[0], ends[1], heights[1]);
        if (distance < best) [best, which] = [distance, k];
      }
    });
    if (which < 0) return null;
    const rank = `${which + 1} of ${rollouts.length}`;
    return { title: "rollout", rows: [["cost", `${rollouts[which].cost} s`], ["rank", rank]] };
  }
}

// How often the picture is drawn: a browser that is slow at it leaves the time to the robot's own nodes.

const FAST = 30; // ms: a picture that takes no longer is drawn in every frame of the browser
const RAREST = 250; // ms between two pictures at most
const LEARNING = 0.2; // share of the newest picture in what one is taken to cost

/** Says in which frames of the browser to draw: where pictures are slow, at most half of the time. */
class Pacing {
  constructor() {
    this.cost = 0; // ms
    this.begun = null; // moment of the picture whose cost is not known yet
    this.due = -Infinity;
  }

  /**
   * Whether to draw in the frame of a moment [ms, of requestAnimationFrame]. The browser calls for the next frame once it has
   * the last one on the screen: that a picture was drawn and the next frame was late tells what it cost.
   */
  draws(moment) {
    if (this.begun !== null) {
      this.cost += LEARNING * (Math.min(moment - this.begun, RAREST) - this.cost);
      this.due = this.cost > FAST ? this.begun + Math.min(2 * this.cost, RAREST) : -Infinity;
      this.begun = null;
    }
    if (moment < this.due) return false;
    this.begun = moment;
    return true;
  }
}

// Small plots of the last seconds.


const SHOWN = 20; // s, or a whole run that is shorter
const GAP = 1; // s without a figure, over which no line is drawn
const LEGIBLE = 12; // px between two figures of an axis

function nice(value) {
  const power = 10 ** Math.floor(Math.log10(Math.max(value, 1e-9)));
  return [1, 1.6, 2, 3, 4, 6, 8, 10].map((each) => each * power).find((each) => each >= value);
}

/** One plot of lines [{name, points: [{t, value}, ...]}, ...]. */
class Plot {
  constructor(parent, title, unit, digits) {
    Object.assign(this, { unit, digits });
    this.box = element("div", parent, "plot");
    const head = element("div", this.box, "head");
    element("span", head).textContent = title;
    this.figure = element("b", head);
    this.canvas = element("canvas", this.box);
    this.names = element("div", this.box, "names");
    this.named = "";
  }

  draw(lines, [begin, end], now, colors) {
    const shown = lines.map(({ name, points }) => {
      const first = Math.max(0, firstAfter(points, begin) - 1);
      return { name, points: points.slice(first, firstAfter(points, now)) };
    });
    const values = shown.flatMap(({ points }) => points.map(({ value }) => value));
    this.box.hidden = !values.length;
    if (this.box.hidden) return;
    const { canvas } = this;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const ctx = canvas.getContext("2d");
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.clearRect(0, 0, width, height);
    const [least, most] = [Math.min(0, ...values), Math.max(0, ...values)];
    const bottom = least < 0 ? -nice(-least) : 0;
    const top = most > 0 ? nice(most) : least < 0 ? 0 : 1;
    const [left, right, high, low] = [34, width - 2, 5, height - 5];
    const sx = (t) => left + ((t - begin) / (end - begin)) * (right - left);
    const sy = (value) => low - ((value - bottom) / (top - bottom)) * (low - high);
    const middle = bottom < 0 && top > 0 ? 0 : (bottom + top) / 2;
    const ticks = [bottom, middle, top].filter((tick) => tick === middle || Math.abs(sy(tick) - sy(middle)) > LEGIBLE);
    this.drawAxis(ctx, ticks, sy, left, right, colors);
    ctx.save();
    ctx.beginPath();
    ctx.rect(left, 0, right - left, height);
    ctx.clip();
    shown.forEach(({ points }, k) => this.drawLine(ctx, points, sx, sy, lines.length > 1 ? colors.terms[k % 8] : colors.plotLine));
    ctx.restore();
    this.write(shown, colors);
  }

  drawAxis(ctx, ticks, sy, left, right, colors) {
    ctx.font = "10px system-ui, sans-serif";
    ctx.textAlign = "right";
    ctx.textBaseline = "middle";
    ctx.lineWidth = 1;
    for (const tick of ticks) {
      ctx.strokeStyle = colors.plotGrid;
      ctx.beginPath();
      ctx.moveTo(left, sy(tick));
      ctx.lineTo(right, sy(tick));
      ctx.stroke();
      ctx.fillStyle = colors.muted;
      ctx.fillText(String(Number(tick.toPrecision(3))), left - 5, sy(tick));
    }
  }

  drawLine(ctx, points, sx, sy, color) {
    ctx.strokeStyle = color;
    ctx.lineWidth = 1.6;
    ctx.lineJoin = "round";
    ctx.beginPath();
    let last = -Infinity;
    for (const { t, value } of points) {
      if (t - last > GAP) ctx.moveTo(sx(t), sy(value));
      else ctx.lineTo(sx(t), sy(value));
      last = t;
    }
    ctx.stroke();
  }

  write(shown, colors) {
    const last = shown[0]?.points.at(-1)?.value;
    this.figure.textContent = last === undefined ? "–" : `${last.toFixed(this.digits)} ${this.unit}`;
    const names = shown.length > 1 ? shown.map(({ name }) => name.replaceAll("_", " ")) : [];
    const named = `${names.join()} ${colors.dark}`;
    if (named === this.named) return;
    this.named = named;
    this.names.replaceChildren();
    names.forEach((name, k) => {
      const item = element("span", this.names);
      element("i", item).style.background = colors.terms[k % 8];
      item.append(name);
    });
  }
}

/** All plots, of a scene: its last seconds, or those of a run that begins and ends. */
class Plots {
  constructor(parent, scene, begin = -Infinity, end = Infinity) {
    this.scene = scene;
    this.begin = begin;
    this.span = Math.min(SHOWN, end - begin);
    const which = this.span < SHOWN ? "the whole run," : "the last";
    element("p", parent, "note", `${which} ${Number(this.span.toPrecision(2))} s`);
    this.speed = new Plot(parent, "speed", "m/s", 2);
    this.distance = new Plot(parent, "distance to the goal", "m", 2);
    this.planning = new Plot(parent, "planning time", "ms", 0);
    this.period = new Plot(parent, "control period", "ms", 0);
    this.terms = new Plot(parent, "cost of the choice", "", 2);
  }

  draw(now, colors) {
    const { track, series } = this.scene;
    const begin = Math.max(this.begin, now - this.span);
    const shown = [begin, begin + this.span];
    const speed = [];
    for (let i = firstAfter(track, begin - GAP); i < track.length; i += 1) {
      const { t, vx } = track[i];
      if (vx !== undefined) speed.push({ t, value: track[i].speed / 1000 });
    }
    this.speed.draw([{ name: "speed", points: speed }], shown, now, colors);
    this.distance.draw([{ name: "distance", points: series.distance }], shown, now, colors);
    this.planning.draw([{ name: "planning", points: series.planning }], shown, now, colors);
    this.period.draw([{ name: "period", points: series.period }], shown, now, colors);
    const terms = [...series.terms].filter(([, points]) => points.length && points.at(-1).t > begin);
    terms.sort(([a], [b]) => (b === "total") - (a === "total"));
    this.terms.draw(terms.map(([name, points]) => ({ name, points })), shown, now, colors);
  }
}

// What the page says beside the picture: which robot, what it is doing and why, who takes part, what is shown.


const ROBOTS = {
  simulated: ["SIMULATED", "simulated robot"],
  emulated: ["SIMULATED", "simulated robot behind an emulated firmware"],
  real: ["REAL ROBOT", "real robot"],
  unknown: ["robot not known", "whether the robot is simulated is not known"],
};
const LEVELS = ["ok", "warn", "error", "error"];
const SIGNS = { ok: "●", warn: "▲", error: "✖", silent: "◌" };

/** Which robot, what it is doing, and how the nodes are. */
class Panels {
  constructor(scene) {
    this.nodes = "";
    this.show(scene);
  }

  /** Writes what is of another scene. */
  show(scene) {
    this.scene = scene;
    this.version = -1;
  }

  /** Writes what has changed. */
  write() {
    if (this.scene.version === this.version) return;
    this.version = this.scene.version;
    const { about, doing, hold, goal, costs, nodes, counts, machine, drive } = this.scene.parts;
    this.writeAbout(about, costs, machine);
    byId("maneuver").textContent = (doing?.maneuver || "no controller").replaceAll("_", " ");
    byId("goal_status").textContent = goal && goal.status !== "none" ? `· goal ${goal.status}` : "· no goal";
    byId("reason").textContent = doing?.reason ?? "";
    byId("reason").classList.toggle("warning", Boolean(doing?.warn));
    const held = hold && hold.state !== "free" && hold.message;
    byId("hold").hidden = !held;
    byId("hold").textContent = held ? hold.message : "";
    byId("machine").hidden = !machine?.verdict;
    byId("machine").textContent = machine?.verdict ?? "";
    byId("learnt").hidden = !drive;
    byId("learnt").textContent = drive?.message ?? "";
    byId("learnt").classList.toggle("warning", Boolean(drive?.warn));
    byId("counts").textContent = counted(counts ?? {});
    this.writeNodes(nodes ?? []);
  }

  writeAbout(about, costs, machine) {
    const badge = byId("badge");
    badge.hidden = !about;
    if (!about) return;
    const [sign, words] = ROBOTS[about.robot] ?? ROBOTS.unknown;
    badge.textContent = machine?.pace ? `${sign} · ${machine.pace}` : sign;
    badge.dataset.robot = about.robot;
    const told = [words, costs?.strategy, about.world, about.namespace === "/" ? "" : about.namespace];
    byId("about").textContent = told.filter(Boolean).join(" · ") + (about.trouble ? ` · no walls: ${about.trouble}` : "");
    byId("speed_high").textContent = `${(about.max_speed / 1000).toFixed(1)} m/s`;
  }

  writeNodes(nodes) {
    const text = JSON.stringify(nodes.map(({ name, level, message, age, silent }) => [name, level, message, silent && age]));
    if (text === this.nodes) return;
    this.nodes = text;
    const list = byId("nodes");
    list.replaceChildren();
    if (!nodes.length) element("p", list, "note", "none has reported");
    for (const { name, level, message, age, silent, values } of nodes) {
      const state = silent ? "silent" : LEVELS[level] ?? "error";
      const row = element("div", list, `node ${state}`);
      element("span", row, "sign", SIGNS[state]);
      element("b", row, "", name.slice(name.lastIndexOf("/") + 1) + (silent ? `: silent for ${age} s` : ""));
      element("p", row, "", message);
      row.title = Object.entries(values).map(([key, value]) => `${key}: ${value}`).join("\n");
    }
  }
}

/** Impacts measured, by their kind, in words: a deliberate one is foreseen too, and counted once. */
function counted({ deliberate = 0, foreseen = 0, other = 0 }) {
  const all = deliberate + foreseen + other;
  if (!all) return "no impact yet";
  return `${all} impact${all > 1 ? "s" : ""}: ${deliberate} deliberate, ${foreseen} more foreseen, ${other} other`;
}

/** Switches of the layers of all pictures. */
class LayerList {
  constructor(pictures, colors) {
    const hidden = new Set();
    for (const picture of pictures) picture.hidden = hidden;
    this.samples = [];
    const off = new Set(kept("layers_off") ?? []);
    for (const layer of LAYERS) {
      const label = element("label", byId("layers"));
      const box = element("input", label);
      box.type = "checkbox";
      box.checked = !off.has(layer.id);
      if (!box.checked) hidden.add(layer.id);
      const sample = element("canvas", label);
      this.samples.push([layer, sample]);
      element("span", label, "", layer.label);
      box.addEventListener("change", () => {
        if (box.checked) hidden.delete(layer.id);
        else hidden.add(layer.id);
        keep("layers_off", [...hidden]);
        for (const picture of pictures) picture.stale = true;
      });
    }
    this.paint(colors);
  }

  /** Draws the samples in other colours. */
  paint(colors) {
    const ratio = window.devicePixelRatio || 1;
    for (const [layer, canvas] of this.samples) {
      canvas.width = 26 * ratio;
      canvas.height = 14 * ratio;
      const ctx = canvas.getContext("2d");
      ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
      layer.sample(ctx, colors);
    }
  }
}

/** What is pointed at, beside the pointer. */
function showTip(tip, found, pointer) {
  tip.hidden = !found;
  if (!found) return;
  tip.replaceChildren();
  element("b", tip, "", found.title);
  const table = element("table", tip);
  for (const [name, value] of found.rows) {
    const row = element("tr", table);
    element("td", row, "", name);
    element("td", row, "", value);
  }
  const ground = tip.parentElement.getBoundingClientRect();
  const [x, y] = pointer;
  tip.style.left = `${Math.min(x + 14, ground.width - tip.offsetWidth - 6)}px`;
  tip.style.top = `${Math.min(y + 14, ground.height - tip.offsetHeight - 6)}px`;
}

let toastEnds = 0;

/** Says something for a moment. */
function toast(text, failed = false) {
  const box = byId("toast");
  box.textContent = text;
  box.hidden = !text;
  box.classList.toggle("failed", failed);
  clearTimeout(toastEnds);
  toastEnds = setTimeout(() => (box.hidden = true), failed ? 8000 : 3000);
}

// What the page asks for: a goal, cancel, resume, stop, and another strategy.


const SAME_PLACE = 200; // mm within which a second click is meant for the same goal
const UNCONFIRMED = 700; // ms after which a stop that the robot has not confirmed is reported

/** The buttons, the strategy, and a goal by a click. A field that was changed gives the focus back: space then stops. */
class Drive {
  constructor(source, scene, picture) {
    this.source = source;
    this.scene = scene;
    byId("drive").hidden = false;
    picture.onclick = (x, y) => this.goTo(x, y);
    byId("stop").addEventListener("click", () => this.stop());
    for (const name of ["cancel", "resume"]) byId(name).addEventListener("click", () => this.act({ do: name }));
    byId("clear_stop").addEventListener("click", () => this.act({ do: "clear_estop" }));
    byId("strategy").addEventListener("change", (event) => {
      this.act({ do: "strategy", name: event.target.value });
      event.target.blur();
    });
  }

  /** Gives a goal [mm]; one inside of a drawn wall, which may be drawn wrongly, once it was clicked twice. */
  goTo(x, y) {
    const { world } = this.scene.parts;
    const again = this.questioned && Math.hypot(x - this.questioned.x, y - this.questioned.y) < SAME_PLACE;
    this.questioned = world && !again && isSolid(world, x, y) ? { x, y } : null;
    if (this.questioned) toast("that is inside a wall of the world file: click there again to give it all the same", true);
    else this.act({ do: "goal", x: x / 1000, y: y / 1000 });
  }

  /** Sends a command and says what came of it. */
  async act(command) {
    const { ok, text } = await this.source.send(command);
    toast(text || (ok ? "done" : "failed"), !ok);
  }

  async stop() {
    const late = setTimeout(() => toast("STOP is not confirmed: use the robot's own button", true), UNCONFIRMED);
    const { ok, text } = await this.source.send({ do: "estop" });
    clearTimeout(late);
    toast(ok ? text : `STOP failed: ${text}: use the robot's own button`, !ok);
  }

  /** Writes what has changed. */
  write() {
    const { hold, strategy, costs } = this.scene.parts;
    byId("clear_stop").hidden = hold?.state !== "stopped";
    const select = byId("strategy");
    select.disabled = !strategy;
    if (!strategy) return;
    if (select.options.length !== strategy.choices.length) {
      select.replaceChildren();
      strategy.choices.forEach((choice) => (element("option", select, "", choice).value = choice));
    }
    const value = (this.scene.active && costs?.strategy) || strategy.value;
    if (document.activeElement !== select || select.dataset.shown !== value) select.value = value;
    select.dataset.shown = value;
  }
}

// The page: a source of frames, live or recorded, and everything that shows them.


const PLOT_EVERY = 100; // ms
const KEYS = [
  ["space", "STOP, wherever the focus is but in a field"],
  ["wheel, + −", "nearer, farther"],
  ["drag", "move the picture"],
  ["F", "everything in sight"],
  ["R", "stay with the robot"],
  ["D", "light or dark"],
];

/**
 * Shows a source: {live, runs, begin, end, onframe, onreset, onstatus, now(), send(command)}. It calls `onframe` with frames
 * in the order of their time and which run they are of, `onreset` before ones of another time, `onstatus` with a text and
 * whether it is trouble; `now` is the moment to draw, on the clock of the frames, which is from `begin` to `end` in recorded
 * runs, and from `first` to `last` in each, which have `title` and `end`. `send` returns a promise of {ok, text}, and is
 * asked for where it is live alone.
 */
function start(source) {
  const scenes = source.runs.map(() => new Scene());
  const pictures = scenes.map((scene) => pictureOf(scene, source.live));
  const captions = pictures.length > 1 ? captioned(pictures) : [];
  let colors = new Colors(isDark());
  const panels = new Panels(scenes[0]);
  const layers = new LayerList(pictures, colors);
  const plots = new Plots(byId("plots"), scenes[0], source.begin, source.end);
  const drive = source.live ? new Drive(source, scenes[0], pictures[0]) : null;

  /** Shows at the side what a run did. */
  function choose(which) {
    panels.show(scenes[which]);
    plots.scene = scenes[which];
    pictures.forEach(({ box }, k) => box.setAttribute("aria-current", String(k === which)));
  }
  if (captions.length) {
    pictures.forEach(({ canvas }, k) => canvas.addEventListener("focus", () => choose(k)));
    choose(0);
  }

  function paint() {
    colors = new Colors(isDark());
    document.documentElement.dataset.theme = colors.dark ? "dark" : "light";
    byId("theme").textContent = colors.dark ? "light" : "dark";
    for (const picture of pictures) Object.assign(picture, { colors, stale: true });
    layers.paint(colors);
    paintSpeeds(colors);
  }

  function switchTheme() {
    keep("theme", colors.dark ? "light" : "dark");
    paint();
  }

  function follow() {
    const following = !pictures[0].following;
    for (const picture of pictures) Object.assign(picture, { following, stale: true });
  }

  const tools = {
    zoom_in: () => pictures[0].zoom(1.25),
    zoom_out: () => pictures[0].zoom(0.8),
    fit: () => pictures.forEach((picture) => picture.fit()),
    follow,
    theme: switchTheme,
  };
  for (const [id, act] of Object.entries(tools)) byId(id).addEventListener("click", act);
  const keys = {
    "+": tools.zoom_in, "-": tools.zoom_out, f: tools.fit, r: follow, d: switchTheme, " ": () => drive?.stop(),
  };
  document.addEventListener("keydown", (event) => {
    const act = keys[event.key.toLowerCase()];
    if (!act || event.target.tagName === "SELECT" || event.ctrlKey || event.metaKey || event.altKey || (event.key === " " && !drive)) return;
    event.preventDefault();
    if (event.key !== " " || !event.repeat) act();
  });
  for (const [key, words] of KEYS) {
    if (key === "space" && !drive) continue;
    element("dt", byId("keys"), "", key);
    element("dd", byId("keys"), "", words);
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
  paint();

  source.onframe = (frame, run = 0) => scenes[run].push(frame);
  source.onreset = () => scenes.forEach((scene) => scene.reset());
  source.onstatus = (text, trouble) => {
    byId("status").textContent = text;
    byId("status").classList.toggle("trouble", Boolean(trouble));
  };

  const pacing = new Pacing();
  let plotted = -Infinity;
  function draw(moment) {
    requestAnimationFrame(draw);
    if (!pacing.draws(moment)) return;
    const now = source.now();
    source.runs.forEach(({ first, last }, k) => {
      const moment = Math.min(Math.max(now, first), last);
      scenes[k].advance(moment);
      pictures[k].draw(moment);
    });
    captions.forEach((caption, k) => writeCaption(caption, source.runs[k], scenes[k], now));
    panels.write();
    if (moment - plotted > PLOT_EVERY) {
      plotted = moment;
      plots.draw(now, colors);
      drive?.write();
      byId("follow").setAttribute("aria-pressed", String(pictures[0].following));
    }
  }
  requestAnimationFrame(draw);
}

/** A picture of a scene at the end of the others. */
function pictureOf(scene, live) {
  const box = element("figure", byId("pictures"), "picture");
  const ground = element("div", box, "ground");
  const canvas = element("canvas", ground, live ? "" : "replayed");
  const tip = element("div", ground, "tip");
  tip.hidden = true;
  canvas.tabIndex = 0;
  canvas.ariaLabel = `the robot from above${live ? "; a click sets the goal" : ""}`;
  const picture = new SceneCanvas(canvas, scene);
  picture.box = box;
  picture.onhover = (found, pointer) => showTip(tip, found, pointer);
  return picture;
}

/** Lets pictures show the same place; gives the caption of each. */
function captioned(pictures) {
  byId("pictures").classList.add("several");
  return pictures.map((picture) => {
    picture.beside = pictures.filter((each) => each !== picture);
    const caption = document.createElement("figcaption");
    picture.box.prepend(caption);
    return { title: element("b", caption), state: element("div", caption) };
  });
}

/** Writes which run it is and what came of it until now. */
function writeCaption({ title, state }, run, scene, now) {
  title.textContent = run.title;
  const words = now < run.last ? `${now.toFixed(2)} s · ${counted(scene.parts.counts ?? {})}` : run.end;
  if (state.textContent !== words) state.textContent = words;
}

/** Whether the page is dark: as it was switched, else as the browser asks for it. */
function isDark() {
  const chosen = kept("theme");
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

function paintSpeeds(colors) {
  const canvas = byId("speed_bar");
  const ctx = canvas.getContext("2d");
  for (let x = 0; x < canvas.width; x += 1) {
    ctx.fillStyle = colors.speed(x / (canvas.width - 1));
    ctx.fillRect(x, 0, 1, canvas.height);
  }
}

// Recorded runs in the place of the live connection, and the bar at the bottom that moves through them, on one clock.


const RECORDED_LEAD = 0.1; // s: the robot is drawn between two frames, so the later one must be there before its time
const RECORDED_HISTORY = 60; // s of trail and plots that are there after a jump
const RECORDED_PARTS = ["robot", "trail", "refused", "costs", "periods"]; // of which the history consists
const PARTS_OF_ONE_FRAME = new Set(["trail", "refused", "periods"]);
const LONGEST_STEP = 0.5; // s: a page that was hidden goes on where it was
const SAME_MOMENT = 1e-4; // s
const PLAYER_SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
const PLAYER_KEYS = [
  ["space", "play, pause"],
  ["< >", "to the plan before, after"],
  [", .", "to the impact before, after"],
];
const HALF_A_THUMB = 8; // px: so far from the ends of the bar its own ends are

class RecordedSource {
  live = false;
  onframe = () => {};
  onreset = () => {};
  onstatus = () => {};
  onmoved = () => {};
  playing = false;
  speed = 1;

  constructor(recordings) {
    this.runs = recordings.map((run) => ({ ...run, next: 0, first: run.frames[0].t, last: run.frames.at(-1).t }));
    this.begin = Math.min(...this.runs.map(({ first }) => first));
    this.end = Math.max(...this.runs.map(({ last }) => last));
    this.time = this.begin;
    this.clock = null;
    this.planTimes = this.timesOf((frame) => frame.plan);
    this.impactTimes = this.timesOf((frame) => frame.impacts?.length);
    this.refusedTimes = this.timesOf((frame) => frame.refused);
  }

  timesOf(has) {
    return this.runs.flatMap(({ frames }) => frames.filter(has).map((frame) => frame.t)).sort((a, b) => a - b);
  }

  now() {
    const clock = performance.now() / 1000;
    if (this.playing && this.clock !== null) {
      this.time = Math.min(this.end, this.time + this.speed * Math.min(clock - this.clock, LONGEST_STEP));
    }
    this.clock = clock;
    this.runs.forEach((run, k) => {
      while (run.next < run.frames.length && run.frames[run.next].t <= this.time + RECORDED_LEAD) {
        this.onframe(run.frames[run.next], k);
        run.next += 1;
      }
    });
    if (this.time >= this.end) {
      this.playing = false;
    }
    this.onmoved();
    return this.time;
  }

  play() {
    if (this.time >= this.end - SAME_MOMENT) {
      this.seek(this.begin);
    }
    this.playing = true;
  }

  pause() {
    this.playing = false;
  }

  seek(time) {
    this.time = Math.min(Math.max(time, this.begin), this.end);
    this.onreset();
    this.runs.forEach((run, k) => {
      const later = run.frames.findIndex((frame) => frame.t > this.time + SAME_MOMENT);
      run.next = Math.max(later < 0 ? run.frames.length : later, 1);
      this.onframe(knownOf(run.frames.slice(0, run.next)), k);
    });
  }

  step(times, direction) {
    const ahead = times.filter((time) => direction * (time - this.time) > SAME_MOMENT);
    this.pause();
    if (ahead.length) {
      this.seek(direction > 0 ? ahead[0] : ahead[ahead.length - 1]);
    }
  }
}

// What is known after these frames, as one of them
function knownOf(frames) {
  const newest = {};
  for (const frame of frames) {
    for (const part of Object.keys(frame)) {
      if (!PARTS_OF_ONE_FRAME.has(part)) {
        newest[part] = frame[part];
      }
    }
  }
  const recent = frames.filter((frame) => frame.t >= newest.t - RECORDED_HISTORY);
  return { ...newest, history: recent.map(historyOf) };
}

function historyOf(frame) {
  const kept = { t: frame.t };
  for (const part of RECORDED_PARTS.filter((each) => each in frame)) {
    kept[part] = frame[part];
  }
  return kept;
}

function momentIn(hash) {
  const match = /^#t=(-?\d+(?:\.\d+)?)$/.exec(hash);
  return match ? Number(match[1]) : null;
}

class Transport {
  constructor(box, source) {
    this.source = source;
    this.shown = "";
    this.button = element("button", box, "play");
    this.bar = this.track(box);
    this.clock = element("output", box, "clock");
    this.speeds(box);
    this.steps(box, "plan", [["◂", "<"], ["▸", ">"]], source.planTimes);
    this.steps(box, "impact", [["|◂", ","], ["▸|", "."]], source.impactTimes);
    this.moment = element("a", box, "moment");
    this.moment.title = "a link to this moment: copy its address";
    source.runs.forEach((run) => this.tell(run));
    for (const [key, words] of PLAYER_KEYS) {
      element("dt", byId("keys"), "", key);
      element("dd", byId("keys"), "", words);
    }
    box.hidden = false;
    this.button.addEventListener("click", () => this.toggle());
    this.bar.addEventListener("input", () => this.jump(this.bar.valueAsNumber));
    this.bar.addEventListener("change", () => this.remember());
    document.addEventListener("keydown", (event) => this.press(event));
    window.addEventListener("hashchange", () => this.follow(window.location.hash));
    source.onmoved = () => this.show();
  }

  tell({ title, end, reason, notes }) {
    const told = byId("told");
    element("p", told, "", `${title}: ${end}`);
    if (reason) element("p", told, "warning", reason);
    for (const note of notes) element("p", told, "note", note);
    told.hidden = false;
  }

  track(box) {
    const track = element("div", box, "track");
    const span = Math.max(this.source.end - this.source.begin, SAME_MOMENT);
    const marks = [["refused", this.source.refusedTimes], ["impact", this.source.impactTimes]];
    for (const [kind, time] of marks.flatMap(([kind, times]) => times.map((time) => [kind, time]))) {
      const share = (time - this.source.begin) / span;
      const mark = element("i", track, kind);
      mark.style.left = `calc(${HALF_A_THUMB}px + ${share} * (100% - ${2 * HALF_A_THUMB}px))`;
    }
    const bar = element("input", track, "bar");
    bar.type = "range";
    Object.assign(bar, { min: this.source.begin, max: this.source.end, step: 0.01, title: "time" });
    return bar;
  }

  speeds(box) {
    const choice = element("select", box, "speed");
    choice.title = "speed";
    for (const speed of PLAYER_SPEEDS) element("option", choice, "", `${speed}x`).value = String(speed);
    choice.value = "1";
    choice.addEventListener("change", () => {
      this.source.speed = Number(choice.value);
    });
  }

  steps(box, name, [back, on], times) {
    const both = element("span", box, "steps");
    const step = ([sign, key], words, direction) => {
      const button = element("button", both, "step", sign);
      button.title = `to the ${name} ${words}, key ${key}`;
      button.ariaLabel = button.title;
      button.disabled = times.length === 0;
      button.addEventListener("click", () => this.step(times, direction));
    };
    step(back, "before", -1);
    element("span", both, "what", name);
    step(on, "after", 1);
  }

  press(event) {
    const at = event.target;
    const writes = at instanceof HTMLSelectElement || (at instanceof HTMLInputElement && at !== this.bar);
    if (writes || event.ctrlKey || event.altKey || event.metaKey) {
      return;
    }
    const { planTimes, impactTimes } = this.source;
    const acts = new Map([
      [" ", () => this.toggle()],
      ["<", () => this.step(planTimes, -1)],
      [">", () => this.step(planTimes, 1)],
      [",", () => this.step(impactTimes, -1)],
      [".", () => this.step(impactTimes, 1)],
    ]);
    // the space bar presses a button that has the focus anyway
    if (acts.has(event.key) && !(event.key === " " && at instanceof HTMLButtonElement)) {
      event.preventDefault();
      acts.get(event.key)();
    }
  }

  toggle() {
    if (this.source.playing) {
      this.source.pause();
      this.remember();
    } else {
      this.source.play();
    }
  }

  step(times, direction) {
    this.source.step(times, direction);
    this.remember();
  }

  jump(time) {
    this.source.pause();
    this.source.seek(time);
  }

  follow(hash) {
    const moment = momentIn(hash);
    if (moment !== null) {
      this.jump(moment);
    }
    return moment !== null;
  }

  remember() {
    this.show();
    try {
      window.history.replaceState(null, "", this.moment.getAttribute("href"));
    } catch {
      // a browser that forbids it to a file: the link beside the clock has the moment all the same
    }
  }

  show() {
    const { time, end, playing } = this.source;
    const words = `${time.toFixed(2)} / ${end.toFixed(2)} s`;
    const button = playing ? "pause" : "play";
    if (this.shown === words + button) {
      return;
    }
    this.shown = words + button;
    this.clock.value = words;
    this.bar.value = String(time);
    this.button.textContent = button;
    this.moment.textContent = `#t=${time.toFixed(2)}`;
    this.moment.href = this.moment.textContent;
  }
}

async function unpacked(text) {
  const packed = Uint8Array.from(atob(text.trim()), (character) => character.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return JSON.parse(await new Response(stream).text());
}

async function playRecordings() {
  const box = byId("transport");
  let recordings = null;
  try {
    recordings = await Promise.all([...document.querySelectorAll(".recording")].map((each) => unpacked(each.textContent)));
  } catch (error) {
    element("span", box, "note", `what is in this file cannot be unpacked: ${error.message}`);
    element("span", box, "note", "Chrome, Firefox and Safari can since 2023, if the file is whole");
    box.hidden = false;
    return;
  }
  const source = new RecordedSource(recordings);
  const transport = new Transport(box, source);
  start(source);
  source.onstatus("recorded", false);
  source.seek(source.begin);
  const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
  if (!transport.follow(window.location.hash) && !still) {
    source.play();
  }
}
playRecordings();
})();
