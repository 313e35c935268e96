// The page: a source of frames, live or recorded, and everything that shows them.

import { SceneCanvas } from "./canvas.js";
import { Colors } from "./colors.js";
import { byId, element, keep, kept } from "./dom.js";
import { Drive } from "./drive.js";
import { LayerList, Panels, counted, showTip } from "./panels.js";
import { Pacing } from "./pacing.js";
import { Plots } from "./plots.js";
import { Scene } from "./state.js";

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
export function start(source) {
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
