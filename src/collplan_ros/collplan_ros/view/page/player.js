// Recorded runs in the place of the live connection, and the bar at the bottom that moves through them, on one clock.

import { byId, element } from "./dom.js";
import { start } from "./page.js";

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

export class RecordedSource {
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

export function momentIn(hash) {
  const match = /^#t=(-?\d+(?:\.\d+)?)$/.exec(hash);
  return match ? Number(match[1]) : null;
}

export class Transport {
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

export async function unpacked(text) {
  const packed = Uint8Array.from(atob(text.trim()), (character) => character.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return JSON.parse(await new Response(stream).text());
}

export async function playRecordings() {
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
