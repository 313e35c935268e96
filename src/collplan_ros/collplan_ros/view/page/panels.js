// What the page says beside the picture: which robot, what it is doing and why, who takes part, what is shown.

import { byId, element, keep, kept } from "./dom.js";
import { LAYERS } from "./layers.js";

const ROBOTS = {
  simulated: ["SIMULATED", "simulated robot"],
  emulated: ["SIMULATED", "simulated robot behind an emulated firmware"],
  real: ["REAL ROBOT", "real robot"],
  unknown: ["robot not known", "whether the robot is simulated is not known"],
};
const LEVELS = ["ok", "warn", "error", "error"];
const SIGNS = { ok: "●", warn: "▲", error: "✖", silent: "◌" };

/** Which robot, what it is doing, and how the nodes are. */
export class Panels {
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
export function counted({ deliberate = 0, foreseen = 0, other = 0 }) {
  const all = deliberate + foreseen + other;
  if (!all) return "no impact yet";
  return `${all} impact${all > 1 ? "s" : ""}: ${deliberate} deliberate, ${foreseen} more foreseen, ${other} other`;
}

/** Switches of the layers of all pictures. */
export class LayerList {
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
export function showTip(tip, found, pointer) {
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
export function toast(text, failed = false) {
  const box = byId("toast");
  box.textContent = text;
  box.hidden = !text;
  box.classList.toggle("failed", failed);
  clearTimeout(toastEnds);
  toastEnds = setTimeout(() => (box.hidden = true), failed ? 8000 : 3000);
}
