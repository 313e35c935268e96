"""The source of the live page, as the browser's own language runs it; needs Node, and is left out without it."""

import json
import shutil
import subprocess
from importlib.resources import files
from itertools import pairwise
from typing import Any

import pytest

NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(NODE is None, reason="no Node here")

HEAD = """
import { liveSource } from "./live.js";
const input = JSON.parse(process.argv[2]);
let wall = 0;
let socket = null;
let look = null;
Object.defineProperty(globalThis, "performance", { value: { now: () => 1000 * wall } });
globalThis.document = { querySelector: () => ({ content: "token" }) };
globalThis.location = { host: "here" };
globalThis.WebSocket = class extends EventTarget {
  static OPEN = 1;
  readyState = 1;
  constructor() { super(); socket = this; }
};
globalThis.setTimeout = (act) => act();
globalThis.setInterval = (act) => { look = act; };
const source = liveSource();
source.onframe = () => {};
const frame = (t) => socket.dispatchEvent(Object.assign(new Event("message"), { data: JSON.stringify({ t }) }));
"""


@pytest.fixture
def run(tmp_path):
    """Runs lines of JavaScript beside the source; returns what they leave in `result`."""
    (tmp_path / "package.json").write_text('{"type": "module"}')
    (tmp_path / "live.js").write_text((files("collplan_ros.view") / "page" / "live.js").read_text(encoding="utf-8"))

    def run(lines: str, **given: Any) -> Any:
        program = tmp_path / "program.js"
        program.write_text(HEAD + lines + "\nprocess.stdout.write(JSON.stringify(result));\n")
        command = [NODE, str(program), json.dumps(given)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


@pytest.mark.parametrize("pace", [0.05, 0.3, 1.0, 4.0, 30.0], ids=lambda pace: f"{pace:g}_s_a_second")
def test_the_picture_goes_as_evenly_as_the_frames_and_a_little_behind_them(run, pace):
    lines = """
    const result = [];
    for (let k = 0; k < 360; k += 1) {
      wall = k / 60;
      if (k % 3 === 0) frame(100 + input.pace * wall);
      result.push([100 + input.pace * wall, source.now()]);
    }
    """
    settled = run(lines, pace=pace)[180:]
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
    socket.dispatchEvent(new Event("open"));
    for (const t of [0, 1, 2]) {
      wall = t;
      frame(t);
      look();
    }
    for (const t of [3, 4.2, 7]) {
      wall = t;
      look();
    }
    frame(3);
    look();
    socket.readyState = 3;
    wall = 20;
    look();
    """
    old = "what you see is old"
    assert run(lines) == [
        [0, "", False],
        [4.2, f"nothing from view_node for 2 s: {old}", True],
        [7, f"nothing from view_node for 5 s: {old}", True],
        [7, "", False],
    ]


def test_a_page_that_never_gets_a_frame_says_so(run):
    lines = """
    const result = [];
    source.onstatus = (text) => result.push(text);
    look();
    socket.dispatchEvent(new Event("open"));
    wall = 3;
    look();
    """
    assert run(lines) == ["", "nothing from view_node for 3 s: what you see is old"]
