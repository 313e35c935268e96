"""STOP is always at hand: keys and fields of the page, as the browser's own language runs them; needs Node."""

import json
import shutil
import subprocess
from importlib.resources import files
from typing import Any

import pytest

NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(NODE is None, reason="no Node here")

PAGE = files("collplan_ros.view") / "page"
STUBS = {
    "dom.js": """
        const elements = new Map();
        class Element extends EventTarget {
          type = "text";
          dataset = {};
          classList = { toggle() {} };
          blurred = 0;
          blur() { this.blurred += 1; }
          getContext() { return {}; }
          setAttribute() {}
        }
        export function byId(id) {
          if (!elements.has(id)) elements.set(id, new Element());
          return elements.get(id);
        }
        export const element = () => new Element();
        export const keep = () => {};
        export const kept = () => null;
    """,
    "pacing.js": "export class Pacing {}",
    "canvas.js": "export class SceneCanvas { zoomed = 0; zoom() { this.zoomed += 1; } }",
    "colors.js": "export class Colors {}",
    "panels.js": """
        export class Panels {}
        export class LayerList { paint() {} }
        export function showTip() {}
        export function toast() {}
    """,
    "plots.js": "export class Plots {}",
    "state.js": "export class Scene { parts = {}; }",
}
HEAD = """
globalThis.document = Object.assign(new EventTarget(), { documentElement: { dataset: {} } });
globalThis.matchMedia = () => Object.assign(new EventTarget(), { matches: false });
globalThis.requestAnimationFrame = () => {};
const { byId } = await import("./dom.js");
const { start } = await import("./page.js");
const { Drive, ParameterList } = await import("./drive.js");
const sent = [];
const answered = Promise.resolve({ ok: true, text: "" });
const source = { live: true, send: (command) => (sent.push(command), answered) };
function press(key, repeat, target = document) {
  const event = Object.assign(new Event("keydown", { cancelable: true }), { key, repeat });
  target.dispatchEvent(event);
  return event.defaultPrevented;
}
"""


@pytest.fixture
def run(tmp_path):
    """Runs lines of JavaScript beside the page's keys and fields; returns what they leave in `result`."""
    (tmp_path / "package.json").write_text('{"type": "module"}')
    for name in ("page.js", "drive.js", "geometry.js"):
        (tmp_path / name).write_text((PAGE / name).read_text(encoding="utf-8"))
    for name, text in STUBS.items():
        (tmp_path / name).write_text(text)

    def run(lines: str) -> Any:
        program = tmp_path / "program.js"
        program.write_text(HEAD + lines + "\nprocess.stdout.write(JSON.stringify(result));\n")
        done = subprocess.run([NODE, str(program)], capture_output=True, text=True, timeout=60, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


def test_the_space_bar_stops_once_for_each_time_it_is_pressed(run):
    """Held it repeats 30 times a second, and a page that sends so many commands is closed."""
    lines = """
    start(source);
    const prevented = [];
    for (const repeat of [false, true, true, true, false, true]) prevented.push(press(" ", repeat));
    const result = [sent, prevented];
    """
    sent, prevented = run(lines)
    assert sent == [{"do": "estop"}] * 2
    assert prevented == [True] * 6


def test_other_keys_repeat_while_they_are_held(run):
    lines = """
    const { picture } = start(source);
    for (const repeat of [false, true, true]) press("+", repeat);
    const result = picture.zoomed;
    """
    assert run(lines) == 3


def test_a_goal_inside_of_a_drawn_wall_is_given_by_a_second_click_there(run):
    lines = """
    const world = { bounds: [0, 0, 4000, 4000], walled: true, polygons: [[0, 0, 1000, 0, 1000, 4000, 0, 4000]],
                    circles: [[3000, 3000, 200]] };
    const picture = {};
    new Drive(source, { parts: { world } }, picture);
    const clicks = [[2000, 2000], [500, 500], [3000, 3100], [500, 510], [480, 500], [500, 500], [4100, 2000]];
    const result = clicks.map((at) => {
      picture.onclick(...at);
      return sent.length;
    });
    """
    assert run(lines) == [1, 1, 1, 1, 2, 2, 2]


def test_a_field_that_was_changed_has_the_focus_no_more(run):
    lines = """
    const drive = new Drive(source, { parts: {} }, {});
    const strategy = byId("strategy");
    strategy.value = "bounce";
    strategy.dispatchEvent(new Event("change"));
    const entry = { name: "planner.goal_tolerance", doc: "", kind: "float", low: null, high: null, choices: [] };
    const field = new ParameterList(drive, { parts: {} }).field(byId("parameters"), "/planner_node", entry);
    field.value = "0.1";
    field.dispatchEvent(new Event("change"));
    const result = [sent.map(({ value }) => value), strategy.blurred, field.blurred];
    """
    assert run(lines) == [["bounce", 0.1], 1, 1]
