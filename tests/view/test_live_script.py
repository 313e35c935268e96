"""The clock of the live page, as the browser's own language runs it; needs Node, and is left out without it."""

import json
import shutil
import subprocess
from importlib.resources import files
from itertools import pairwise

import pytest

NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(NODE is None, reason="no Node here")

PROGRAM = """
import { liveSource } from "./live.js";
const { pace, seconds } = JSON.parse(process.argv[2]);
let wall = 0;
let socket = null;
Object.defineProperty(globalThis, "performance", { value: { now: () => 1000 * wall } });
globalThis.document = { querySelector: () => ({ content: "token" }) };
globalThis.location = { host: "here" };
globalThis.WebSocket = class extends EventTarget {
  constructor() { super(); socket = this; }
};
globalThis.setTimeout = (act) => act();
const source = liveSource();
source.onframe = () => {};
const shown = [];
for (let k = 0; k < 60 * seconds; k += 1) {
  wall = k / 60;
  if (k % 3 === 0) {
    const data = JSON.stringify({ t: 100 + pace * wall });
    socket.dispatchEvent(Object.assign(new Event("message"), { data }));
  }
  shown.push([100 + pace * wall, source.now()]);
}
process.stdout.write(JSON.stringify(shown));
"""


@pytest.mark.parametrize("pace", [0.05, 0.3, 1.0, 4.0, 30.0], ids=lambda pace: f"{pace:g}_s_a_second")
def test_the_picture_goes_as_evenly_as_the_frames_and_a_little_behind_them(tmp_path, pace):
    (tmp_path / "package.json").write_text('{"type": "module"}')
    (tmp_path / "live.js").write_text((files("collplan_ros.view") / "page" / "live.js").read_text(encoding="utf-8"))
    (tmp_path / "program.js").write_text(PROGRAM)
    given = json.dumps({"pace": pace, "seconds": 6})
    done = subprocess.run(
        [NODE, str(tmp_path / "program.js"), given], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stderr
    settled = json.loads(done.stdout)[180:]
    behind = [(robot - shown) / pace for robot, shown in settled]
    assert min(behind) > 0.05
    assert max(behind) < 0.2
    steps = [60 * (b - a) / pace for (_, a), (_, b) in pairwise(settled)]
    assert min(steps) > 0.7
    assert max(steps) < 1.3
