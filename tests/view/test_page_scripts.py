"""The scripts of the live page and of the player, as the browser's own language runs them; needs Node."""

import json
import shutil
import subprocess
from importlib.resources import files
from typing import Any

import numpy as np
import pytest

from collplan_ros.run.page.one_file import page_script

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
    script.write_text(page_script())
    done = subprocess.run([NODE, "--check", str(script)], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr


# ---- the player of recorded runs, here of two on one clock

FRAMES = [
    {"t": -0.1, "robot": [0, 0, 0, 0, 0], "world": None, "impacts": [], "goal": {"at": [5, 5], "status": "none"}},
    {"t": 0.0, "robot": [1, 0, 0, 0, 0], "plan": {"stamp": -0.02}, "costs": {"planning_time": 1, "terms": {}}},
    {"t": 0.05, "robot": [2, 0, 0, 0, 0], "trail": [10, 1, 0], "periods": [50]},
    {"t": 0.4, "robot": [3, 0, 0, 0, 0], "plan": {"stamp": 0.38}, "impacts": [{"t": 0.39}]},
    {"t": 0.8, "robot": [4, 0, 0, 0, 0], "plan": {"stamp": 0.78}, "scan": [7, 7]},
]
RUNS = [FRAMES, [FRAMES[1], {"t": 0.5, "robot": [9, 0, 0, 0, 0], "periods": [51]}]]
"""The second begins later and ends earlier."""
PLAYER = f"""
import {{ RecordedSource }} from "./player.js";
{CLOCK}
const source = new RecordedSource(input.runs.map((frames) => ({{ frames }})));
const got = [];
source.onframe = (frame, run) => got.push([run, frame]);
source.onreset = () => got.push("reset");
"""
PLAYER_STUBS = {
    "page.js": "export function start() {}\n",
    "dom.js": "export function byId() {}\nexport function element() {}\n",
}


@pytest.fixture
def play(run):
    return lambda lines, **given: run(PLAYER + lines, "player.js", stubs=PLAYER_STUBS, given={"runs": RUNS, **given})


def test_playing_gives_each_frame_once_in_order_and_before_its_time(play):
    lines = """
    source.seek(-1);
    source.play();
    const result = [];
    for (let k = 0; k < 30; k += 1) {
      wall += 0.05;
      const now = source.now();
      const given = [0, 1].map((run) => got.filter(([of]) => of === run).map(([, frame]) => frame.t));
      result.push([now, given, source.playing]);
    }
    """
    for now, given, playing in play(lines):
        for times, (first, *later) in zip(given, RUNS, strict=True):
            assert times == [first["t"], *(frame["t"] for frame in later if frame["t"] <= now + 0.1)]
        assert playing == (now < 0.8)
    assert now == 0.8


def test_a_jump_shows_what_playing_would_have_shown(play):
    lines = "const result = input.times.map((time) => { got.length = 0; source.seek(time); return [...got]; });"
    times = [-5, -0.1, -0.01, 0.0, 0.06, 0.4, 0.79, 0.8, 5]
    for time, (reset, *given) in zip(times, play(lines, times=times), strict=True):
        assert (reset, [run for run, _ in given]) == ("reset", [0, 1])
        for frames, (_, merged) in zip(RUNS, given, strict=True):
            passed = [frame for frame in frames if frame["t"] <= max(time, frames[0]["t"])]
            expected = {part: value for frame in passed for part, value in frame.items()}
            expected = {part: value for part, value in expected.items() if part not in ("trail", "periods")}
            history = merged.pop("history")
            assert merged == expected
            kept = {"t", "robot", "trail", "costs", "periods"}
            assert history == [{part: frame[part] for part in frame if part in kept} for frame in passed]


# ---- what is drawn

DRAWN = """
import { LAYERS, Picture } from "./layers.js";
import { Colors } from "./colors.js";
const arcs = [];
const lines = [];
const ctx = new Proxy({ arc: (...to) => arcs.push(to), lineTo: (...to) => lines.push(to) }, {
  get: (to, name) => to[name] ?? (() => {}),
  set: () => true,
});
const view = { scale: 0.1, sx: (x) => 0.1 * x, sy: (y) => -0.1 * y };
const picture = new Picture(ctx, view, new Colors(false), { parts: input.parts }, input.now);
LAYERS.find((layer) => layer.id === "movers").draw(picture);
const result = { arcs, lines };
"""


@pytest.mark.parametrize(("now", "moved"), [(2.0, 0.0), (2.2, 0.2), (9.0, 0.3)])
def test_what_moves_is_drawn_where_it_is_by_now_with_an_arrow_where_it_moves(run, now, moved):
    parts = {
        "movers": {"stamp": 2.0, "at": [1000, 500, -400, 200, 150]},
        "found": {"stamp": 2.0, "at": [0, 0, 0, 0, 100]},
    }
    drawn = run(DRAWN, "layers.js", "colors.js", "geometry.js", given={"parts": parts, "now": now})
    x, y = 100.0 - 40.0 * moved, -50.0 - 20.0 * moved
    assert [arc[:3] for arc in drawn["arcs"]] == [pytest.approx([x, y, 15.0]), pytest.approx([0.0, 0.0, 10.0])]
    # the head of the arrow is half a second ahead
    assert np.hypot(*(np.array(drawn["lines"]) - [x - 20.0, y - 10.0]).T).min() < 12.0
    assert run(DRAWN, "layers.js", "colors.js", "geometry.js", given={"parts": {}, "now": now})["arcs"] == []
