// What the page knows: the newest of each part of the frames, the way of the robot, and what is plotted.

import { firstAfter, wrapped } from "./geometry.js";

const KEPT = 60; // s of way and plots
const STEP_BACK = 0.5; // s: a frame that is so much earlier begins another time
const RESTED = 0.5; // s for which a robot at rest has to have been there
const REST_SPEED = 150; // mm/s: the noise of the velocity measured is less, but for rare ones
const REST_DRIFT = 5; // mm from the one half of that time to the other
const MOST_QUEUED = 60; // frames: a page that was hidden does not replay what it missed

/** Frames in, their state at a time out. */
export class Scene {
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
