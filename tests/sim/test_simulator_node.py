"""The simulated robot on the graph, in one process with a probe; its clean end as a process of its own."""

import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, Twist, Vector3Stamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from serial_robot import HALL
from visualization_msgs.msg import MarkerArray

from collplan_core.worlds import Mover, load_world, save_world
from collplan_core.worlds.movers import place_at
from collplan_ros.messages.mover_markers import movers_to_markers
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, EVENT, EVERY_ONE, NEWEST, POSE_SUBSCRIBED
from collplan_ros.messages.reading import MessageError, movers_from_markers
from omnipuck_sim.node.simulator_node import SimulatorNode

EXECUTABLE = [sys.executable, "-c", "import sys; from omnipuck_sim.node.simulator_node import main; sys.exit(main())"]
HEARD = (
    ("ground_truth/odom", Odometry, EVENT),
    ("mocap/pose", PoseStamped, EVERY_ONE),
    ("ground_truth/impact", Vector3Stamped, EVENT),
    ("/diagnostics", DiagnosticArray, DIAGNOSTICS_SUBSCRIBED),
    ("/clock", Clock, EVERY_ONE),
)


class Bench:
    def __init__(self, ros, world: str, **parameters) -> None:
        self.ros = ros
        self.heard = {topic: ros.listen(kind, topic, qos) for topic, kind, qos in HEARD}
        ros.make(SimulatorNode, {"simulator.world": world, "simulator.noise": 0.0, **parameters})
        self.commands = ros.publisher(Twist, "cmd_vel", NEWEST)
        self.until(lambda: self.odometry and self.heard["/diagnostics"])

    def until(self, condition: Callable[[], object]) -> None:
        assert self.ros.wait_until(condition, timeout=30.0), "waited in vain"

    @property
    def odometry(self) -> list[Odometry]:
        return self.heard["ground_truth/odom"]

    @property
    def x(self) -> float:
        return self.odometry[-1].pose.pose.position.x


def seconds(stamp) -> float:
    return stamp.sec + stamp.nanosec * 1e-9


@pytest.fixture
def bench(ros, tmp_path):
    path = tmp_path / "hall.yaml"
    path.write_text(HALL)
    return partial(Bench, ros, str(path))


def test_poses_come_at_100_hz_with_noise_and_the_truth_beside_them(bench):
    begun = time.time()
    b = bench(**{"simulator.noise": 1.0})
    b.until(lambda: len(b.heard["mocap/pose"]) > 40)
    poses = b.heard["mocap/pose"]
    stamps = np.array([seconds(p.header.stamp) for p in poses])
    assert np.min(np.diff(stamps)) == pytest.approx(0.01, abs=1e-4)
    assert begun < stamps[-1] < time.time()
    assert {p.header.frame_id for p in poses} == {"map"}
    # in real time it leaves the clock alone
    assert b.ros.probe.count_publishers("/clock") == 0
    assert (b.odometry[-1].header.frame_id, b.odometry[-1].child_frame_id) == ("map", "base_link")
    offsets = [p.pose.position.x - b.x for p in poses]
    assert 0.001 < np.std(offsets) < 0.003


def test_poses_are_sent_late_by_the_latency_of_the_motion_capture(bench):
    latency = 0.4
    b = bench(**{"simulator.mocap_latency": latency})
    poses, truths = b.heard["mocap/pose"], b.odometry
    b.until(lambda: len(poses) > 10)
    # the truth is sent at once
    b.until(
        lambda: seconds(truths[-1].header.stamp) - seconds(poses[-1].header.stamp) == pytest.approx(latency, abs=0.1)
    )


def test_at_another_speed_it_publishes_the_clock_its_stamps_are_in(bench):
    b = bench(**{"simulator.speed_factor": 0.5})
    b.until(lambda: len(b.heard["mocap/pose"]) > 40)
    stamps = [seconds(p.header.stamp) for p in b.heard["mocap/pose"]]
    b.until(lambda: seconds(b.heard["/clock"][-1].clock) >= stamps[-1])
    assert stamps[-1] < 60.0
    # a busy machine may lose some
    periods = np.diff(stamps) / 0.01
    assert periods == pytest.approx(np.round(periods), abs=1e-4)
    assert periods.min() == pytest.approx(1.0)


def test_granted_time_passes_to_the_next_pose_that_is_measured_or_sent(bench):
    b = bench(**{"simulator.speed_factor": 0.0, "simulator.mocap_latency": 0.005})
    b.until(lambda: len(b.heard["mocap/pose"]) > 3)
    times = [seconds(clock.clock) for clock in b.heard["/clock"][-6:]]
    assert np.diff(times) == pytest.approx(np.full(5, 0.005), abs=1e-4)


def test_movers_are_published_with_the_stamps_of_the_truth(ros, tmp_path):
    path = tmp_path / "moved.yaml"
    mover = Mover(0.15, np.array([[0.4, 0.4], [2.0, 0.4]]), 0.5, delay=0.1)
    save_world(replace(load_world("floor"), movers=(mover,)), path)
    heard = ros.listen(MarkerArray, "ground_truth/movers", EVENT)
    b = Bench(ros, str(path), **{"simulator.speed_factor": 0.5})
    b.until(lambda: len(heard) > 30)
    stamps = {seconds(odometry.header.stamp) for odometry in b.odometry}
    for message in heard:
        stamp, movers = movers_from_markers(message, "map")
        np.testing.assert_allclose(movers[:, [0, 1, 4]], [[*place_at(mover, stamp), 0.15]], atol=1e-6)
        assert movers[0, 2:4].tolist() in ([0.0, 0.0], pytest.approx([0.5, 0.0]))
    assert len(stamps & {seconds(message.markers[0].header.stamp) for message in heard}) > 20
    for bad in (MarkerArray(), movers_to_markers(1.0, np.array([[0.0, np.nan, 0.0, 0.0, 0.1]]), "map")):
        with pytest.raises(MessageError, match="markers: "):
            movers_from_markers(bad, "map")


WITHOUT_MUJOCO = """
import sys
sys.modules["mujoco"] = None
from omnipuck_sim.{module} import main
sys.exit(main())
"""


@pytest.mark.parametrize(
    ("module", "option", "why"),
    [
        ("node.simulator_node", "simulator.engine:=mujoco", "mujoco-core"),
        ("emulator.firmware_emulator", "simulator.engine:=mujoco", "mujoco-core"),
        ("node.simulator_node", "simulator.world:=nowhere", "nowhere"),
        ("node.simulator_node", "simulator.speed_factor:=0.0", "speed_factor"),
    ],
)
def test_what_is_not_there_is_one_line_and_code_2(module, option, why):
    command = [sys.executable, "-c", WITHOUT_MUJOCO.format(module=module), "--ros-args", "-p", option]
    run = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert run.returncode == 2
    assert why in run.stderr
    assert "Traceback" not in run.stderr


def test_as_a_process_it_ends_cleanly_on_sigterm(ros):
    poses = ros.listen(PoseStamped, "mocap/pose", POSE_SUBSCRIBED)
    with subprocess.Popen(EXECUTABLE, stderr=subprocess.PIPE, text=True) as process:
        came = ros.wait_until(lambda: poses, timeout=30.0)
        process.terminate()
        try:
            _, errors = process.communicate(timeout=30.0)
        finally:
            process.kill()
    assert came
    assert process.returncode == 0
    assert "Traceback" not in errors
