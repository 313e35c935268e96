"""Refusals of bringup to start: one sentence and exit code 2, before the first node."""

import errno
import os
import socket
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace

import pytest

from collplan_core.parameters import Mocap, ParameterError, Settings
from collplan_ros.bringup.ending import NOT_STARTED, StartError
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.node_kit import reachability
from collplan_ros.node_kit.reachability import graph_environment, why_no_graph, why_no_logs

BRINGUP = [str(Path(sys.executable).with_name("bringup")), "--no-pictures"]


def started(program=BRINGUP, **variables):
    """Exit code and output of bringup, or of another program, with these environment variables; None removes one."""
    env = {**os.environ, **{key: value for key, value in variables.items() if value is not None}}
    for key in (key for key, value in variables.items() if value is None):
        env.pop(key, None)
    done = subprocess.run(program, env=env, capture_output=True, text=True, errors="replace", timeout=60)
    return done.returncode, done.stdout + done.stderr


ENFORCED = {"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce"}


def test_variables_of_ros_by_which_no_node_meets_another_are_named():
    for variables, local, words in (
        ({"ROS_DOMAIN_ID": "232"}, False, ""),
        ({"ROS_DOMAIN_ID": "233"}, False, "ROS_DOMAIN_ID: got '233', expected a whole number in [0, 232]"),
        ({"ROS_DOMAIN_ID": "1.5"}, True, "ROS_DOMAIN_ID: got '1.5'"),
        ({**ENFORCED, "ROS_SECURITY_KEYSTORE": "/nowhere"}, True, "ROS_SECURITY_KEYSTORE: got '"),
        ({**ENFORCED, "ROS_SECURITY_STRATEGY": "Permissive"}, True, ""),
        ({"ROS_LOCALHOST_ONLY": "1"}, False, "ROS_LOCALHOST_ONLY: got '1'"),
        ({"ROS_LOCALHOST_ONLY": "1"}, True, ""),
    ):
        why = why_no_graph(variables, local)
        assert why.startswith(words), variables
        assert bool(why) == bool(words), variables
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as server:
        server.bind(("127.0.0.1", 0))
        port = server.getsockname()[1]
        answers = {"ROS_DISCOVERY_SERVER": f"127.0.0.1:{port}"}
        assert why_no_graph(answers, local=False) == ""
    assert f"no server listens at 127.0.0.1:{port}" in why_no_graph(answers, local=False)
    # the nodes of a simulated robot meet by themselves
    assert graph_environment("local", answers, alone=True)["ROS_DISCOVERY_SERVER"] == ""


@pytest.mark.parametrize("local", [True, False])
def test_only_a_local_graph_needs_the_loopback_interface(monkeypatch, local):
    def unreachable(*_):
        raise OSError(errno.ENETUNREACH, "Network is unreachable")

    monkeypatch.setattr(reachability.socket, "socket", lambda *_: SimpleNamespace(connect=unreachable, close=int))
    expected = "the loopback interface is down (Network is unreachable): ip link set lo up" if local else ""
    assert why_no_graph({}, local) == expected


def test_a_file_system_without_links_costs_the_link_alone(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(os, "symlink", refuse)
    folder = RunFolder(tmp_path, Settings())
    assert folder.become_latest().startswith(f"no link {tmp_path / 'latest'}: Operation not permitted")
    assert folder.serial.parent != folder.path
    assert [path.name for path in tmp_path.iterdir()] == [folder.path.name]


def test_a_node_needs_a_folder_for_the_logs_of_ros():
    for key in ("ROS_LOG_DIR", "ROS_HOME", "HOME"):
        assert why_no_logs({key: "/somewhere"}) == ""
        for none in ({}, {key: ""}, {"ROS_LOG_DIR": "", "HOME": "", "USER": "me"}):
            assert why_no_logs(none) == "ROS_LOG_DIR: not set, and no HOME either, expected a folder for ROS's logs"


def test_a_node_or_a_graph_that_ros_does_not_start_says_so_in_one_sentence(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    node = [str(Path(sys.executable).with_name("planner_node"))]
    for program, variables, words in (
        (node, {"ROS_LOG_DIR": "/proc/nope"}, "/proc/nope"),
        (node, {"ROS_DOMAIN_ID": "300"}, "planner_node: ROS_DOMAIN_ID: got '300'"),
        (BRINGUP, {"ROS_LOG_DIR": "/dev/null/logs", "HOME": None}, "ROS does not start: "),
    ):
        code, said = started(program=program, **variables)
        assert (code, len(said.splitlines())) == (NOT_STARTED, 1), said
        assert words in said
    # the middleware ends the process by itself
    code, said = started(RMW_IMPLEMENTATION="rmw_none_cpp")
    assert (code != 0, "Traceback" in said, "rmw_none_cpp" in said) == (True, False, True)
    assert not list(tmp_path.glob("runs/*/run.mcap"))


def test_a_folder_that_ros_cannot_be_told_is_an_error(tmp_path):
    with pytest.raises(StartError, match="reads paths as UTF-8"):
        RunFolder(tmp_path / "caf\udce9", Settings())


def test_names_of_topics_are_accepted_or_refused_as_ros_does():
    for topic in ("/vrpn_mocap/omnipuck/pose", "~/pose", "_p/_q", "{node}/pose", "/" + "a" * 246):
        assert Mocap(topic=topic).topic == topic
    for topic in (
        "omni-puck/pose",
        "entity/1/pose",
        "",
        "pose/",
        "a//b",
        "pösé",
        "~x",
        "a\n",
        "{no}/pose",
        "/" + "a" * 247,
    ):
        with pytest.raises(ParameterError, match=r"mocap\.topic: got .* expected a name of ROS"):
            Mocap(topic=topic)


def test_output_that_cannot_show_a_letter_ends_nothing(tmp_path):
    code, said = started([*BRINGUP, "--world", str(tmp_path / "wörld.yaml")], PYTHONIOENCODING="ascii")
    assert code == NOT_STARTED
    assert "w\\xf6rld.yaml: no such file" in said
