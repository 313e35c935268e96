// What the page asks for: a goal, cancel, resume, stop, and another strategy.

import { byId, element } from "./dom.js";
import { isSolid } from "./geometry.js";
import { toast } from "./panels.js";

const SAME_PLACE = 200; // mm within which a second click is meant for the same goal
const UNCONFIRMED = 700; // ms after which a stop that the robot has not confirmed is reported

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
