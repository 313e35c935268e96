"""The scripts of the live page and of the player, as the browser's own language runs them; needs Node."""

import json
import shutil
import subprocess
from importlib.resources import files
from typing import Any

import pytest

from collplan_ros.view.player.one_file import SCRIPTS, one_script

NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(NODE is None, reason="no Node here")

PAGE = {each.name: each.read_text(encoding="utf-8") for each in (files("collplan_ros.view") / "page").iterdir()}
CLOCK = """
let wall = 0;
Object.defineProperty(globalThis, "performance", { value: { now: () => 1000 * wall } });
"""


@pytest.fixture
def run(tmp_path):
    """Runs a program beside modules of the page; returns what it leaves in `result`."""

    def run(program: str, *modules: str, stubs: dict[str, str] | None = None, given: Any = None) -> Any:
        named = {name: PAGE[name] for name in modules} | (stubs or {})
        text = f"const input = JSON.parse(process.argv[2]);\n{program}\nprocess.stdout.write(JSON.stringify(result));\n"
        for name, content in {**named, "program.js": text, "package.json": '{"type": "module"}'}.items():
            (tmp_path / name).write_text(content)
        command = [NODE, str(tmp_path / "program.js"), json.dumps(given)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


def test_the_modules_of_the_page_together_are_a_script(tmp_path):
    script = tmp_path / "page.mjs"
    script.write_text(one_script({name: PAGE[name] for name in SCRIPTS}))
    done = subprocess.run([NODE, "--check", str(script)], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr


# ---- the player of a recorded run

FRAMES = [
    {"t": -0.1, "robot": [0, 0, 0, 0, 0], "world": None, "impacts": [], "goal": {"at": [5, 5], "status": "none"}},
    {"t": 0.0, "robot": [1, 0, 0, 0, 0], "plan": {"stamp": -0.02}, "costs": {"planning_time": 1, "terms": {}}},
    {"t": 0.05, "robot": [2, 0, 0, 0, 0], "trail": [10, 1, 0], "periods": [50]},
    {"t": 0.4, "robot": [3, 0, 0, 0, 0], "plan": {"stamp": 0.38}, "impacts": [{"t": 0.39}]},
    {"t": 0.8, "robot": [4, 0, 0, 0, 0], "plan": {"stamp": 0.78}, "scan": [7, 7]},
]
PLAYER = f"""
import {{ RecordedSource }} from "./player.js";
{CLOCK}
const source = new RecordedSource(input.frames);
const got = [];
source.onframe = (frame) => got.push(frame);
source.onreset = () => got.push("reset");
"""
PLAYER_STUBS = {
    "page.js": "export function start() {}\n",
    "dom.js": "export function byId() {}\nexport function element() {}\n",
}


@pytest.fixture
def play(run):
    """Runs lines beside a player of FRAMES."""
    return lambda lines, **given: run(
        PLAYER + lines, "player.js", stubs=PLAYER_STUBS, given={"frames": FRAMES, **given}
    )


def test_playing_gives_each_frame_once_in_order_and_before_its_time(play):
    lines = """
    source.seek(-1);
    source.play();
    const result = [];
    for (let k = 0; k < 30; k += 1) {
      wall += 0.05;
      const now = source.now();
      result.push([now, got.filter((frame) => frame !== "reset").map((frame) => frame.t), source.playing]);
    }
    """
    for now, given, playing in play(lines):
        assert given == [frame["t"] for frame in FRAMES if frame["t"] <= max(now + 0.1, -0.1)]
        assert playing == (now < 0.8)
    assert now == 0.8


def test_a_jump_shows_what_playing_would_have_shown(play):
    lines = "const result = input.times.map((time) => { got.length = 0; source.seek(time); return [...got]; });"
    times = [-5, -0.1, -0.01, 0.0, 0.06, 0.4, 0.79, 0.8, 5]
    for time, (reset, merged) in zip(times, play(lines, times=times), strict=True):
        assert reset == "reset"
        passed = [frame for frame in FRAMES if frame["t"] <= max(time, -0.1)]
        expected = {part: value for frame in passed for part, value in frame.items()}
        expected = {part: value for part, value in expected.items() if part not in ("trail", "periods")}
        history = merged.pop("history")
        assert merged == expected
        kept = {"t", "robot", "trail", "costs", "periods"}
        assert history == [{part: frame[part] for part in frame if part in kept} for frame in passed]


# ---- the source of the live page

LIVE = f"""
import {{ liveSource }} from "./live.js";
{CLOCK}
let socket = null;
let look = null;
globalThis.document = {{ querySelector: () => ({{ content: "token" }}) }};
globalThis.location = {{ host: "here" }};
globalThis.WebSocket = class extends EventTarget {{
  static OPEN = 1;
  readyState = 1;
  constructor() {{ super(); socket = this; }}
}};
globalThis.setTimeout = (act) => act();
globalThis.setInterval = (act) => {{ look = act; }};
const source = liveSource();
source.onframe = () => {{}};
const frame = (t) => socket.dispatchEvent(Object.assign(new Event("message"), {{ data: JSON.stringify({{ t }}) }}));
"""


def test_a_connection_that_stays_open_and_brings_nothing_is_said_until_it_does(run):
    """As where the network of a tunnel is gone, or view_node is frozen: no `close` comes for minutes."""
    lines = """
    const result = [];
    source.onstatus = (text, trouble) => result.push([wall, text, trouble]);
    const at = (t, brings) => {
      wall = t;
      if (brings) frame(t);
      look();
    };
    look();
    socket.dispatchEvent(new Event("open"));
    at(3);
    for (const t of [10, 11, 12]) at(t, true);
    for (const t of [13, 14.2, 17]) at(t);
    at(17, true);
    socket.readyState = 3;
    at(30);
    """
    said = run(LIVE + lines, "live.js")
    assert [trouble for *_, trouble in said] == [False, True, False, True, True, False]
    assert [when for when, _, trouble in said if trouble] == [3, 14.2, 17]
    assert all(("is old" in text) == trouble for _, text, trouble in said)


# ---- keys and fields of the live page

DRIVE_STUBS = {
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
DRIVE = """
globalThis.document = Object.assign(new EventTarget(), { documentElement: { dataset: {} } });
globalThis.matchMedia = () => Object.assign(new EventTarget(), { matches: false });
globalThis.requestAnimationFrame = () => {};
const { byId } = await import("./dom.js");
const { start } = await import("./page.js");
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
def drive(run):
    """Runs lines beside the page's keys and fields."""
    return lambda lines: run(DRIVE + lines, "page.js", "drive.js", "geometry.js", stubs=DRIVE_STUBS)


def test_the_space_bar_stops_once_for_each_time_it_is_pressed_and_other_keys_repeat(drive):
    """Held it repeats 30 times a second, and a page that sends so many commands is closed."""
    lines = """
    const { picture } = start(source);
    const prevented = [];
    for (const repeat of [false, true, true, true, false, true]) prevented.push(press(" ", repeat));
    for (const repeat of [false, true, true]) press("+", repeat);
    const result = [sent, prevented, picture.zoomed];
    """
    sent, prevented, zoomed = drive(lines)
    assert sent == [{"do": "estop"}] * 2
    assert prevented == [True] * 6
    assert zoomed == 3
