"""The player of a recorded run, as the browser's own language runs it; needs Node, and is left out without it."""

import json
import shutil
import subprocess
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from collplan_ros.view.player.one_file import SCRIPTS, one_script, packed

NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(NODE is None, reason="no Node here")

PAGE = files("collplan_ros.view") / "page"
FRAMES = [
    {"t": -0.1, "robot": [0, 0, 0, 0, 0], "world": None, "impacts": [], "goal": {"at": [5, 5], "status": "none"}},
    {"t": 0.0, "robot": [1, 0, 0, 0, 0], "plan": {"stamp": -0.02}, "costs": {"planning_time": 1, "terms": {}}},
    {"t": 0.05, "robot": [2, 0, 0, 0, 0], "trail": [10, 1, 0], "periods": [50]},
    {"t": 0.4, "robot": [3, 0, 0, 0, 0], "plan": {"stamp": 0.38}, "impacts": [{"t": 0.39}]},
    {"t": 0.8, "robot": [4, 0, 0, 0, 0], "plan": {"stamp": 0.78}, "scan": [7, 7]},
]
HEAD = """
import {RecordedSource, momentIn, unpacked} from "./player.js";
const input = JSON.parse(process.argv[2]);
let wall = 0;
Object.defineProperty(globalThis, "performance", {value: {now: () => 1000 * wall}});
const source = new RecordedSource(input.frames ?? [{t: 0}]);
const got = [];
source.onframe = (frame) => got.push(frame);
source.onreset = () => got.push("reset");
"""


@pytest.fixture
def run(tmp_path):
    """Runs lines of JavaScript beside the player; returns what they leave in `result`."""
    (tmp_path / "package.json").write_text('{"type": "module"}')
    (tmp_path / "page.js").write_text("export function start() {}\n")
    (tmp_path / "dom.js").write_text("export function byId() {}\nexport function element() {}\n")
    (tmp_path / "player.js").write_text((PAGE / "player.js").read_text(encoding="utf-8"))

    def run(lines: str, **given: Any) -> Any:
        program = tmp_path / "program.js"
        program.write_text(HEAD + lines + "\nprocess.stdout.write(JSON.stringify(result));\n")
        done = _node(program, json.dumps(given))
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


def _node(program: Path, *arguments: str) -> subprocess.CompletedProcess:
    return subprocess.run([NODE, str(program), *arguments], capture_output=True, text=True, timeout=60, check=False)


def test_it_unpacks_what_was_packed(run):
    given = {"title": "<b>ü", "frames": FRAMES}
    assert run("const result = await unpacked(input.packed);", packed=packed(given)) == given


def test_playing_gives_each_frame_once_in_order_and_before_its_time(run):
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
    for now, given, playing in run(lines, frames=FRAMES):
        assert given == [frame["t"] for frame in FRAMES if frame["t"] <= max(now + 0.1, -0.1)]
        assert playing == (now < 0.8)
    assert now == 0.8


@pytest.mark.parametrize("speed", [0.1, 4])
def test_it_plays_slower_and_faster(run, speed):
    lines = """
    source.speed = input.speed;
    source.now();
    source.play();
    wall += 0.1;
    const result = source.now();
    """
    assert run(lines, frames=FRAMES, speed=speed) == pytest.approx(-0.1 + 0.1 * speed)


def test_a_page_that_was_hidden_goes_on_where_it_was(run):
    lines = "source.now(); source.play(); wall += 1000; const result = source.now();"
    assert run(lines, frames=FRAMES) == pytest.approx(0.4)


def test_a_jump_shows_what_playing_would_have_shown(run):
    lines = "const result = input.times.map((time) => { got.length = 0; source.seek(time); return [...got]; });"
    times = [-5, -0.1, -0.01, 0.0, 0.06, 0.4, 0.79, 0.8, 5]
    for time, (reset, merged) in zip(times, run(lines, frames=FRAMES, times=times), strict=True):
        assert reset == "reset"
        passed = [frame for frame in FRAMES if frame["t"] <= max(time, -0.1)]
        expected = {part: value for frame in passed for part, value in frame.items()}
        expected = {part: value for part, value in expected.items() if part not in ("trail", "periods")}
        history = merged.pop("history")
        assert merged == expected
        assert [frame["t"] for frame in history] == [frame["t"] for frame in passed]
        kept = {"t", "robot", "trail", "costs", "periods"}
        assert history == [{part: frame[part] for part in frame if part in kept} for frame in passed]


def test_steps_go_from_one_plan_or_impact_to_the_next(run):
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
    assert run(lines, frames=FRAMES) == [[time, False] for time in (0, 0.4, 0.8, 0.8, 0.4, 0.4, 0.4, 0, 0.4)]


def test_at_its_end_it_begins_anew(run):
    lines = "source.seek(9); source.play(); const result = [source.time, source.playing];"
    assert run(lines, frames=FRAMES) == [-0.1, True]


@pytest.mark.parametrize(
    ("fragment", "moment"),
    [("#t=2.31", 2.31), ("#t=-0.5", -0.5), ("#t=3", 3), ("", None), ("#t=", None), ("#t=1e9", None), ("#x=1", None)],
)
def test_a_link_names_a_moment(run, fragment, moment):
    assert run("const result = momentIn(input.fragment);", fragment=fragment) == moment


def test_after_a_jump_the_way_and_the_plots_of_the_time_before_are_there(tmp_path):
    for name in ("geometry.js", "state.js"):
        (tmp_path / name).write_text((PAGE / name).read_text(encoding="utf-8"))
    (tmp_path / "package.json").write_text('{"type": "module"}')
    (tmp_path / "program.js").write_text(
        'import { Scene } from "./state.js";\n'
        "const scene = new Scene();\n"
        "scene.push(JSON.parse(process.argv[2]));\n"
        "scene.advance(Infinity);\n"
        "const { planning, distance } = scene.series;\n"
        "const times = [scene.track, planning, distance].map((list) => [...new Set(list.map(({ t }) => t))]);\n"
        "process.stdout.write(JSON.stringify(times));\n"
    )
    passed = FRAMES[:4]
    merged = {part: value for frame in passed for part, value in frame.items()}
    done = _node(tmp_path / "program.js", json.dumps({**merged, "history": passed}))
    assert done.returncode == 0, done.stderr
    track, planning, distance = json.loads(done.stdout)
    assert track == pytest.approx([-0.1, 0.0, 0.04, 0.05, 0.4])
    assert planning[0] == 0.0
    assert distance == pytest.approx([-0.1, 0.0, 0.05, 0.4])


def test_a_robot_at_rest_has_no_speed_however_noisy_its_velocity(tmp_path):
    for name in ("geometry.js", "state.js"):
        (tmp_path / name).write_text((PAGE / name).read_text(encoding="utf-8"))
    (tmp_path / "package.json").write_text('{"type": "module"}')
    (tmp_path / "program.js").write_text(
        'import { Scene } from "./state.js";\n'
        "const scene = new Scene();\n"
        "for (const frame of JSON.parse(process.argv[2])) scene.push(frame);\n"
        "process.stdout.write(JSON.stringify(scene.track.map(({ speed }) => speed)));\n"
    )

    def speeds(velocity: float) -> list[float]:
        noise = [[3, -2], [-3, 1], [2, 3], [-1, -2], [-1, 0]]
        frames = [
            {"t": 0.05 * k, "robot": [velocity * 0.05 * k + noise[k % 5][0], noise[k % 5][1], 0, 80, 30]}
            for k in range(30)
        ]
        done = _node(tmp_path / "program.js", json.dumps(frames))
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    assert set(speeds(0.0)[15:]) == {0}
    assert min(speeds(60.0)) > 80


def test_the_modules_of_the_page_together_are_a_script(tmp_path):
    script = tmp_path / "page.mjs"
    script.write_text(one_script({name: (PAGE / name).read_text(encoding="utf-8") for name in SCRIPTS}))
    done = subprocess.run([NODE, "--check", str(script)], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
