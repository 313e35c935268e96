"""bringup --view: the page of a run, and the run without its page."""

import json
import os
import re
import signal
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


def test_a_run_is_shown_and_goes_on_without_its_page(tmp_path, parameters):
    options = ("--world", "serpentine:2", "--strategy", "bounce", "--view", "--again", "--no-pictures")
    with Run(tmp_path / "runs", *options, "--params", parameters) as run:
        address = wait_for(lambda: re.search(r"this machine: +(http://127\.0\.0\.1:\d+)", run.text))[1]
        parts = {}
        with connect(address.replace("http", "ws") + "/frames", origin=address, proxy=None) as page:

            def shows(condition):
                with suppress(TimeoutError):
                    parts.update(json.loads(page.recv(timeout=0.1)))
                return condition()

            everything = {"robot", "scan", "free", "rollouts", "plan", "remembered", "impacts", "costs", "nodes"}
            wait_for(lambda: shows(lambda: everything <= parts.keys() and parts["world"] and parts["impacts"]))
            assert parts["about"]["robot"] == "simulated"
            assert {node["name"] for node in parts["nodes"]} >= {"/simulator_node", "/planner_node", "/controller_node"}
        os.kill(nodes_of(run.out)["view_node"], signal.SIGKILL)
        wait_for(lambda: "the run goes on without its page" in run.text)
        assert run.process.poll() is None
        run.process.send_signal(signal.SIGINT)
        assert run.process.wait(60) == 0, run.text
        assert "driven there and back until Ctrl-C" in run.text
