// What the page asks for: a goal, cancel, resume, stop, and other values of live parameters.

import { byId, element } from "./dom.js";
import { isSolid } from "./geometry.js";
import { toast } from "./panels.js";

const STRATEGY = "planner.strategy";
const SAME_PLACE = 200; // mm within which a second click is meant for the same goal
const UNCONFIRMED = 700; // ms after which a stop that the robot has not confirmed is told of

/** The buttons, the strategy, and a goal by a click. A field that was changed gives the focus back: space then stops. */
export class Drive {
  constructor(source, scene, picture) {
    this.source = source;
    this.scene = scene;
    byId("drive").hidden = false;
    picture.onclick = (x, y) => this.goTo(x, y);
    byId("stop").addEventListener("click", () => this.stop());
    for (const name of ["cancel", "resume"]) byId(name).addEventListener("click", () => this.act({ do: name }));
    byId("clear_stop").addEventListener("click", () => this.act({ do: "clear_estop" }));
    byId("strategy").addEventListener("change", (event) => {
      this.act({ do: "set", node: this.planner, name: STRATEGY, value: event.target.value });
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
    return ok;
  }

  async stop() {
    const late = setTimeout(() => toast("STOP is not confirmed: use the robot's own button", true), UNCONFIRMED);
    const { ok, text } = await this.source.send({ do: "estop" });
    clearTimeout(late);
    toast(ok ? text : `STOP failed: ${text}: use the robot's own button`, !ok);
  }

  /** Writes what has changed. */
  write() {
    byId("clear_stop").hidden = this.scene.parts.hold?.state !== "stopped";
    const parameters = this.scene.parts.parameters ?? {};
    const select = byId("strategy");
    this.planner = Object.keys(parameters).find((node) => parameters[node].some(({ name }) => name === STRATEGY));
    const entry = this.planner && parameters[this.planner].find(({ name }) => name === STRATEGY);
    select.disabled = !entry;
    if (!entry) return;
    select.title = entry.doc;
    if (select.options.length !== entry.choices.length) {
      select.replaceChildren();
      entry.choices.forEach((choice) => (element("option", select, "", choice).value = choice));
    }
    const present = this.scene.parts.costs?.strategy;
    const value = this.scene.active && present ? present : entry.value;
    if (document.activeElement !== select || select.dataset.shown !== value) select.value = value;
    select.dataset.shown = value;
  }
}

/** The live parameters of all nodes, by their own descriptions. */
export class ParameterList {
  constructor(drive, scene) {
    this.drive = drive;
    this.scene = scene;
    this.shape = "";
    this.fields = new Map();
    byId("parameters_panel").hidden = false;
    byId("filter").addEventListener("input", () => this.filter());
  }

  write() {
    const parameters = this.scene.parts.parameters ?? {};
    if (parameters === this.shown) return;
    this.shown = parameters;
    const shape = Object.entries(parameters).map(([node, list]) => `${node} ${list.map(({ name }) => name)}`).join();
    if (shape !== this.shape) this.build(parameters);
    this.shape = shape;
    for (const [node, list] of Object.entries(parameters)) {
      for (const entry of list) this.fill(this.fields.get(`${node} ${entry.name}`), entry);
    }
  }

  build(parameters) {
    const box = byId("parameters");
    box.replaceChildren();
    this.fields.clear();
    for (const node of Object.keys(parameters).sort()) {
      if (!parameters[node].length) continue;
      element("h3", box, "", node);
      for (const entry of parameters[node]) this.fields.set(`${node} ${entry.name}`, this.field(box, node, entry));
    }
    this.filter();
  }

  field(box, node, entry) {
    const row = element("div", box, "parameter");
    row.dataset.text = `${node} ${entry.name} ${entry.doc}`.toLowerCase();
    const label = element("label", row);
    element("span", label, "", entry.name);
    const input = element(entry.choices.length ? "select" : "input", label);
    entry.choices.forEach((choice) => (element("option", input, "", choice).value = choice));
    if (entry.kind === "bool") input.type = "checkbox";
    const limits = entry.low === null ? "" : `, ${entry.low} to ${entry.high}`;
    element("p", row, "note", `${entry.doc}${limits}`);
    input.addEventListener("change", () => {
      this.set(node, entry, input);
      input.blur();
    });
    return input;
  }

  async set(node, entry, input) {
    const value = valueOf(entry, input);
    const ok = value !== null && (await this.drive.act({ do: "set", node, name: entry.name, value }));
    if (value === null) toast(`${entry.name}: expected a number`, true);
    input.classList.toggle("changed", ok);
    input.classList.toggle("refused", !ok);
  }

  fill(input, entry) {
    if (!input || document.activeElement === input) return;
    if (entry.kind === "bool") input.checked = entry.value;
    else input.value = Array.isArray(entry.value) ? entry.value.map(shortly).join(", ") : shortly(entry.value);
  }

  filter() {
    const wanted = byId("filter").value.toLowerCase();
    document.querySelectorAll("#parameters .parameter").forEach((row) => {
      row.hidden = !row.dataset.text.includes(wanted);
    });
  }
}

/** A value as it is shown: numbers to six digits. */
function shortly(value) {
  return typeof value === "number" ? String(Number(value.toPrecision(6))) : String(value);
}

/** The value in a field, of the parameter's kind; null where it is none. */
function valueOf({ kind }, input) {
  if (kind === "bool") return input.checked;
  if (kind === "text") return input.value;
  const numbers = input.value.split(",").filter((text) => text.trim()).map(Number);
  if (numbers.some((number) => !Number.isFinite(number))) return null;
  if (kind === "list") return numbers;
  return numbers.length === 1 ? numbers[0] : null;
}
