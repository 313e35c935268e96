// The page: a source of frames, live or recorded, and everything that shows them.

import { SceneCanvas } from "./canvas.js";
import { Colors } from "./colors.js";
import { byId, element, keep, kept } from "./dom.js";
import { Drive, ParameterList } from "./drive.js";
import { LayerList, Panels, showTip } from "./panels.js";
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
 * Shows a source: {live, begin, end, onframe, onreset, onstatus, now(), send(command)}. It calls `onframe` with frames in
 * the order of their time, `onreset` before one of another time, `onstatus` with a text and whether it is trouble; `now` is
 * the moment to draw, on the clock of the frames, which is from `begin` to `end` in a recorded run. `send` returns a promise
 * of {ok, text}, and is asked for where it is live alone.
 */
export function start(source) {
  const scene = new Scene();
  const picture = new SceneCanvas(byId("scene"), scene);
  let colors = new Colors(isDark());
  picture.colors = colors;
  picture.onhover = showTip;
  const panels = new Panels(scene);
  const layers = new LayerList(picture, colors);
  const plots = new Plots(byId("plots"), scene, source.begin, source.end);
  const drive = source.live ? new Drive(source, scene, picture) : null;
  const parameters = drive ? new ParameterList(drive, scene) : null;
  byId("scene").classList.toggle("replayed", !source.live);

  function paint() {
    colors = new Colors(isDark());
    document.documentElement.dataset.theme = colors.dark ? "dark" : "light";
    byId("theme").textContent = colors.dark ? "light" : "dark";
    picture.colors = colors;
    picture.stale = true;
    layers.paint(colors);
    paintSpeeds(colors);
  }

  function switchTheme() {
    keep("theme", colors.dark ? "light" : "dark");
    paint();
  }

  function follow() {
    picture.following = !picture.following;
    picture.stale = true;
  }

  const tools = {
    zoom_in: () => picture.zoom(1.25),
    zoom_out: () => picture.zoom(0.8),
    fit: () => picture.fit(),
    follow,
    theme: switchTheme,
  };
  for (const [id, act] of Object.entries(tools)) byId(id).addEventListener("click", act);
  const keys = {
    "+": tools.zoom_in, "-": tools.zoom_out, f: tools.fit, r: follow, d: switchTheme, " ": () => drive?.stop(),
  };
  document.addEventListener("keydown", (event) => {
    const act = keys[event.key.toLowerCase()];
    const typing = ["text", "search", ""].includes(event.target.type ?? "none") || event.target.tagName === "SELECT";
    if (!act || typing || event.ctrlKey || event.metaKey || event.altKey || (event.key === " " && !drive)) return;
    event.preventDefault();
    // held, it would soon be more commands than a page may send
    if (event.key !== " " || !event.repeat) act();
  });
  for (const [key, words] of KEYS) {
    if (key === "space" && !drive) continue;
    element("dt", byId("keys"), "", key);
    element("dd", byId("keys"), "", words);
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
  paint();

  source.onframe = (frame) => scene.push(frame);
  source.onreset = () => scene.reset();
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
    scene.advance(now);
    picture.draw(now);
    panels.write();
    if (moment - plotted > PLOT_EVERY) {
      plotted = moment;
      plots.draw(now, colors);
      drive?.write();
      parameters?.write();
      byId("follow").setAttribute("aria-pressed", String(picture.following));
    }
  }
  requestAnimationFrame(draw);
  return { scene, picture };
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
