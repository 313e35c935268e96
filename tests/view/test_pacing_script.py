"""How often the page draws, as the browser's own language runs it; needs Node."""

import json
import shutil
import subprocess
from importlib.resources import files

import pytest

NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(NODE is None, reason="no Node here")

PROGRAM = """
import { Pacing } from "./pacing.js";
const [cost, length] = JSON.parse(process.argv[2]);
const pacing = new Pacing();
let drawn = 0;
let frames = 0;
for (let moment = 0; moment < 1000 * length; frames += 1) {
  const draws = pacing.draws(moment);
  if (moment >= 500 * length) drawn += draws;
  moment += draws ? Math.max(cost, 1000 / 60) : 1000 / 60;
}
process.stdout.write(JSON.stringify(drawn / (0.5 * length)));
"""


@pytest.mark.parametrize(("cost", "rate"), [(2.0, 60.0), (25.0, 40.0), (40.0, 12.5), (100.0, 5.0), (400.0, 2.5)])
def test_pictures_that_are_slow_take_half_of_the_time(tmp_path, cost, rate):
    """`cost` [ms] is what the browser takes for a frame in which the page draws, `rate` how many of these a second."""
    page = (files("collplan_ros.view") / "page" / "pacing.js").read_text(encoding="utf-8")
    for name, text in {"package.json": '{"type": "module"}', "pacing.js": page, "program.js": PROGRAM}.items():
        (tmp_path / name).write_text(text)
    command = [NODE, str(tmp_path / "program.js"), json.dumps([cost, 20.0])]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == pytest.approx(rate, rel=0.15)
