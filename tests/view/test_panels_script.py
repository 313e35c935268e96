"""What the page says beside its picture, as the browser's own language runs it; needs Node."""

import json
import shutil
import subprocess
from importlib.resources import files

import pytest

NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(NODE is None, reason="no Node here")

DOM = """
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
PROGRAM = """
import { byId } from "./dom.js";
import { Panels } from "./panels.js";
const said = JSON.parse(process.argv[2]).map((parts) => {
  new Panels({ version: 1, parts }).write();
  return byId("counts").textContent;
});
process.stdout.write(JSON.stringify(said));
"""


def test_impacts_are_counted_whether_they_are_drawn_or_not(tmp_path):
    texts = {
        "package.json": '{"type": "module"}',
        "panels.js": (files("collplan_ros.view") / "page" / "panels.js").read_text(encoding="utf-8"),
        "dom.js": DOM,
        "layers.js": "export const LAYERS = [];",
        "program.js": PROGRAM,
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    drawn = [{"kind": "other"}] * 200
    given = [
        {},
        {"counts": {"deliberate": 0, "foreseen": 1, "other": 0}, "impacts": drawn[:1]},
        {"counts": {"deliberate": 300, "foreseen": 20, "other": 1}, "impacts": drawn},
    ]
    command = [NODE, str(tmp_path / "program.js"), json.dumps(given)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [
        "no impact yet",
        "1 impact: 0 deliberate, 1 more foreseen, 0 other",
        "321 impacts: 300 deliberate, 20 more foreseen, 1 other",
    ]
