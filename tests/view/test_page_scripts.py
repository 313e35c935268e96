"""The scripts of the live page and of the player, as the browser's own language runs them; needs Node."""

import json
import shutil
import subprocess
from importlib.resources import files
from itertools import pairwise
from typing import Any

import pytest

from collplan_ros.view.player.one_file import SCRIPTS, one_script, packed

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
import {{ RecordedSource, momentIn, unpacked }} from "./player.js";
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


def test_the_player_unpacks_what_was_packed(play):
    given = {"title": "<b>ü", "frames": FRAMES}
    assert play("const result = await unpacked(input.packed);", packed=packed(given)) == given


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


def test_it_plays_at_any_speed_begins_anew_at_its_end_and_goes_on_where_a_hidden_page_was(play):
    lines = """
    const result = [];
    for (const speed of [0.1, 4]) {
      source.speed = speed;
      source.seek(9);
      source.now();
      source.play();
      result.push(source.time, source.playing);
      wall += 0.1;
      result.push(source.now());
    }
    source.speed = 1;
    source.seek(-0.1);
    source.now();
    source.play();
    wall += 1000;
    result.push(source.now());
    """
    assert play(lines) == [-0.1, True, pytest.approx(-0.09), -0.1, True, pytest.approx(0.3), pytest.approx(0.4)]


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


def test_steps_go_from_one_plan_or_impact_to_the_next(play):
    lines = """
    const result = [];
    source.seek(-0.1);
    source.play();
    for (const [times, direction] of [["plan", 1], ["plan", 1], ["plan", 1], ["plan", 1], ["plan", -1], ["impact", -1],
                                      ["impact", 1], ["plan", -1], ["impact", 1]]) {
      source.step(times === "plan" ? source.planTimes : source.impactTimes, direction);
      result.push([source.time, source.playing]);
    }
    """
    assert play(lines) == [[time, False] for time in (0, 0.4, 0.8, 0.8, 0.4, 0.4, 0.4, 0, 0.4)]


def test_a_link_names_a_moment(play):
    moments = {"#t=2.31": 2.31, "#t=-0.5": -0.5, "#t=3": 3, "": None, "#t=": None, "#t=1e9": None, "#x=1": None}
    lines = "const result = input.fragments.map((fragment) => momentIn(fragment) ?? null);"
    assert play(lines, fragments=list(moments)) == list(moments.values())


# ---- what is drawn and said


def test_after_a_jump_the_way_and_the_plots_of_the_time_before_are_there(run):
    lines = """
    import { Scene } from "./state.js";
    const scene = new Scene();
    scene.push(input);
    scene.advance(Infinity);
    const { planning, distance } = scene.series;
    const result = [scene.track, planning, distance].map((list) => [...new Set(list.map(({ t }) => t))]);
    """
    passed = FRAMES[:4]
    merged = {part: value for frame in passed for part, value in frame.items()}
    track, planning, distance = run(lines, "geometry.js", "state.js", given={**merged, "history": passed})
    assert track == pytest.approx([-0.1, 0.0, 0.04, 0.05, 0.4])
    assert planning[0] == 0.0
    assert distance == pytest.approx([-0.1, 0.0, 0.05, 0.4])


def test_a_robot_at_rest_has_no_speed_however_noisy_its_velocity(run):
    lines = """
    import { Scene } from "./state.js";
    const result = input.map((frames) => {
      const scene = new Scene();
      for (const frame of frames) scene.push(frame);
      return scene.track.map(({ speed }) => speed);
    });
    """
    noise = [[3, -2], [-3, 1], [2, 3], [-1, -2], [-1, 0]]
    frames = [
        [
            {"t": 0.05 * k, "robot": [velocity * 0.05 * k + noise[k % 5][0], noise[k % 5][1], 0, 80, 30]}
            for k in range(30)
        ]
        for velocity in (0.0, 60.0)
    ]
    resting, moving = run(lines, "geometry.js", "state.js", given=frames)
    assert set(resting[15:]) == {0}
    assert min(moving) > 80


def test_impacts_are_counted_whether_they_are_drawn_or_not(run):
    dom = """
    const elements = new Map();
    const made = () => ({ classList: { toggle() {} }, replaceChildren() {} });
    export function byId(id) {
      if (!elements.has(id)) elements.set(id, made());
      return elements.get(id);
    }
    export const element = made;
    export const keep = () => {};
    export const kept = () => null;
    """
    lines = """
    import { byId } from "./dom.js";
    import { Panels } from "./panels.js";
    const result = input.map((parts) => {
      new Panels({ version: 1, parts }).write();
      return byId("counts").textContent;
    });
    """
    drawn = [{"kind": "other"}] * 200
    given = [{}, {"counts": {"deliberate": 300, "foreseen": 20, "other": 1}, "impacts": drawn}]
    none, many = run(lines, "panels.js", stubs={"dom.js": dom, "layers.js": "export const LAYERS = [];"}, given=given)
    assert "no impact" in none
    assert [word for word in many.replace(":", "").split() if word.isdigit()] == ["321", "300", "20", "1"]


def test_pictures_that_are_slow_take_half_of_the_time(run):
    """`cost` [ms] is what the browser takes for a frame in which the page draws, `rate` how many of these a second."""
    rates = {2.0: 60.0, 25.0: 40.0, 40.0: 12.5, 100.0: 5.0, 400.0: 2.5}
    lines = """
    import { Pacing } from "./pacing.js";
    const result = input.map((cost) => {
      const pacing = new Pacing();
      let drawn = 0;
      for (let moment = 0; moment < 20000;) {
        const draws = pacing.draws(moment);
        if (moment >= 10000) drawn += draws;
        moment += draws ? Math.max(cost, 1000 / 60) : 1000 / 60;
      }
      return drawn / 10;
    });
    """
    assert run(lines, "pacing.js", given=list(rates)) == pytest.approx(list(rates.values()), rel=0.15)


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


@pytest.mark.parametrize("pace", [0.05, 1.0, 30.0])
def test_the_picture_goes_as_evenly_as_the_frames_and_a_little_behind_them(run, pace):
    lines = """
    const result = [];
    for (let k = 0; k < 360; k += 1) {
      wall = k / 60;
      if (k % 3 === 0) frame(100 + input * wall);
      result.push([100 + input * wall, source.now()]);
    }
    """
    settled = run(LIVE + lines, "live.js", given=pace)[180:]
    behind = [(robot - shown) / pace for robot, shown in settled]
    assert min(behind) > 0.05
    assert max(behind) < 0.2
    steps = [60 * (b - a) / pace for (_, a), (_, b) in pairwise(settled)]
    assert min(steps) > 0.7
    assert max(steps) < 1.3


def test_a_connection_that_stays_open_and_brings_nothing_is_said_until_it_does(run):
    """As where the network of a tunnel is gone, or view_node is frozen: no `close` comes for minutes."""
    lines = """
    const result = [];
    source.onstatus = (text, trouble) => result.push([wall, text, trouble]);
    look();
    socket.dispatchEvent(new Event("open"));
    wall = 3;
    look();
    for (const t of [10, 11, 12]) {
      wall = t;
      frame(t);
      look();
    }
    for (const t of [13, 14.2, 17]) {
      wall = t;
      look();
    }
    frame(13);
    look();
    socket.readyState = 3;
    wall = 30;
    look();
    """
    said = run(LIVE + lines, "live.js")
    assert [(when, trouble) for when, _, trouble in said] == [
        (0, False),
        (3, True),
        (10, False),
        (14.2, True),
        (17, True),
        (17, False),
    ]
    assert all(("what you see is old" in text) == trouble for _, text, trouble in said)
    assert [text.split(" s:")[0][-1] for _, text, trouble in said if trouble] == ["3", "2", "5"]


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


def test_a_goal_inside_of_a_drawn_wall_is_given_by_a_second_click_there(drive):
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
    assert drive(lines) == [1, 1, 1, 1, 2, 2, 2]


def test_a_field_that_was_changed_has_the_focus_no_more(drive):
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
    assert drive(lines) == [["bounce", 0.1], 1, 1]
