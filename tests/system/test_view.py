"""bringup --view: the page of a run, and the run without its page."""

import json
import os
import re
import signal
import urllib.request
from contextlib import suppress

import pytest
from bringup_process import Run, nodes_of, wait_for
from websockets.sync.client import connect

pytestmark = pytest.mark.soak


@pytest.fixture
def parameters(tmp_path):
    path = tmp_path / "free_port.yaml"
    path.write_text('"/**":\n  ros__parameters:\n    view:\n      port: 0\n')
    return str(path)


def test_a_run_is_shown_driven_and_goes_on_without_its_page(tmp_path, parameters):
    options = ("--world", "serpentine:2", "--strategy", "bounce", "--view", "--again", "--no-pictures")
    with Run(tmp_path / "runs", *options, "--params", parameters) as run:
        address = wait_for(lambda: re.search(r"this machine: +(http://127\.0\.0\.1:\d+)", run.text))[1]
        token = re.search(r'name="token" content="([^"]+)"', urllib.request.urlopen(address).read().decode())[1]
        parts, answers = {}, {}
        with connect(address.replace("http", "ws") + "/frames", origin=address, proxy=None) as page:

            def shows(condition):
                with suppress(TimeoutError):
                    message = json.loads(page.recv(timeout=0.1))
                    (answers if "answer" in message else parts).update(message)
                return condition()

            everything = {"robot", "scan", "free", "rollouts", "plan", "remembered", "impacts", "costs", "nodes"}
            wait_for(lambda: shows(lambda: "robot" in parts))
            # not where the robot is by then: such a goal is reached before anyone sees that it was given
            goal = [value / 1000 for value in parts["robot"][:2]]
            wait_for(lambda: shows(lambda: everything <= parts.keys() and parts["world"] and parts["impacts"]))
            assert parts["about"]["robot"] == "simulated"
            assert {node["name"] for node in parts["nodes"]} >= {"/simulator_node", "/planner_node", "/controller_node"}
            page.send(json.dumps({"token": token, "number": 1, "do": "estop"}))
            wait_for(lambda: shows(lambda: answers.get("done") and parts["hold"]["state"] == "stopped"))
            wait_for(lambda: "the robot stands until you give it a goal" in run.text)
            page.send(json.dumps({"token": token, "number": 2, "do": "clear_estop"}))
            wait_for(lambda: shows(lambda: parts["hold"]["state"] == "held"))
            page.send(json.dumps({"token": token, "number": 3, "do": "goal", "x": goal[0], "y": goal[1]}))
            wait_for(lambda: shows(lambda: parts["hold"]["state"] == "free"))
        os.kill(nodes_of(run.out)["view_node"], signal.SIGKILL)
        wait_for(lambda: "the run goes on without its page" in run.text)
        assert run.process.poll() is None
        run.process.send_signal(signal.SIGINT)
        assert run.process.wait(60) == 0, run.text
        assert "driven there and back until Ctrl-C" in run.text
