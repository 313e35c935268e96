// What is drawn, layer by layer, from the ground up. A layer draws itself, and a small sample of itself for the list.

import { addLine, addSegments, drawArrow, firstAfter } from "./geometry.js";

const TRAIL_SHOWN = 15; // s
const SMOOTH = 0.025; // s to either side
const FLASH = 0.7; // s for which an impact is seen to happen
const AFTER = 0.22; // s of the velocity after a contact that its arrow is long
const AHEAD = 0.5; // s of the velocity of what moves that its arrow is long
const MOVED_ON = 0.3; // s for which what moves is drawn on from where it was
const SPEED_STEPS = 24; // colours that lines by speed are drawn in

/** A picture at a moment: context, transform, colours, the scene, and the time. */
export class Picture {
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
export function drawGround(picture) {
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
export function drawScale({ ctx, view, colors }) {
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
export function ranks(costs) {
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
export function contactsAhead({ parts, now }) {
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
export const LAYERS = [
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
