// The picture: what is in sight, what is pointed at, and where a click was.

import { Transform, distanceToSegment, freeExtent } from "./geometry.js";
import { LAYERS, Picture, contactsAhead, drawGround, drawScale } from "./layers.js";

const CLICK = 5; // px: a pointer that moved less has clicked
const NEAR = 12; // px within which something is pointed at

/** The canvas of the scene. `onclick(x, y)` is called with the place in mm, where it is set. */
export class SceneCanvas {
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
