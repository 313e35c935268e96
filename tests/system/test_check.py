"""bringup --check against the simulated robot, whose markers sit where the check must find them."""

import math
import os
import sys
import time
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.serialization import serialize_message

from collplan_core.calibration.body_motions import MotionEstimate
from collplan_core.calibration.lidar_fit import LidarMount, MountFit
from collplan_core.calibration.mocap_offset import BodyOffset
from collplan_core.calibration.stream_quality import StreamQuality
from collplan_core.calibration.stroke_fit import AxesFit
from collplan_core.calibration.turn_fit import TurnFit
from collplan_core.command import stopped
from collplan_core.parameters import Lidar, Settings
from collplan_core.parameters.file import read_parameters, write_values
from collplan_core.sensing.mocap_body import with_offset
from collplan_core.sensing.pose_filter import PoseSample
from collplan_core.state import State
from collplan_core.warm_up import warm_up
from collplan_core.worlds.file import parse_text
from collplan_core.worlds.raycast import simulate_scan
from collplan_ros.bringup import check, open_loop
from collplan_ros.bringup.check_findings import (
    DOUBTFUL,
    GOOD,
    WRONG,
    Interruptions,
    axes_finding,
    drift_finding,
    interruption_finding,
    lidar_finding,
    node_findings,
    offset_finding,
    stream_findings,
    turn_finding,
)
from collplan_ros.bringup.failures import GraphError
from collplan_ros.bringup.lidar_scans import LidarScans
from collplan_ros.bringup.main import main
from collplan_ros.bringup.open_loop import OpenLoop
from collplan_ros.bringup.options import ROBOTS
from collplan_ros.bringup.paced_commands import PacedCommands
from collplan_ros.bringup.progress import Progress
from collplan_ros.messages.conversions import scan_to_message, state_to_odometry
from collplan_ros.run.run_log import PoseRow


@pytest.fixture
def options(tmp_path):
    """Writes parameters; the options that name them."""
    warm_up()

    def written(**values):
        write_values({key.replace("__", "."): v for key, v in values.items()}, tmp_path / "given.yaml")
        return ["--check", "--yes", "--params", str(tmp_path / "given.yaml"), "--out", str(tmp_path / "runs")]

    return written


@pytest.mark.soak
@pytest.mark.timeout(900)
@pytest.mark.parametrize("robot", ["sim", "emulator"])
def test_at_the_noise_shipped_the_offset_is_found_and_written(tmp_path, capsys, options, robot):
    """The 10 degrees that mocap.body_offset_yaw says already do not mislead it."""
    placed = {"simulator__marker_offset_x": 0.02, "simulator__marker_offset_yaw": math.radians(6.0)}
    code = main([*options(**placed, mocap__body_offset_yaw=0.17), "--robot", robot])
    said = capsys.readouterr().out
    assert code == 0, said
    found = read_parameters(tmp_path / "runs" / "latest" / "checked.yaml")
    x, y, yaw = (found[f"mocap.body_offset_{key}"] for key in ("x", "y", "yaw"))
    assert math.hypot(x - 0.02, y) < 0.003
    assert yaw == pytest.approx(math.radians(6.0), abs=math.radians(1.0))
    assert found["simulator.marker_offset_x"] == 0.02
    assert "WRONG" not in said


def test_what_cannot_be_checked_is_refused_before_anything_starts(tmp_path, capsys, monkeypatch, options):
    for given in ([*options(), "--world", "corridor"], options(simulator__world="corridor")):
        assert main(given) == 2
        assert "use --world floor" in capsys.readouterr().err
    monkeypatch.setattr(sys.stdin, "isatty", lambda: False, raising=False)
    assert main([o for o in options() if o != "--yes"]) == 2
    assert "--yes" in capsys.readouterr().err
    assert not (tmp_path / "runs").exists()


def test_poses_that_are_not_used_move_nothing_and_are_explained(tmp_path, capsys, options):
    assert main(options(mocap__frame="world")) == 3
    said = capsys.readouterr().out
    assert "header.frame_id: got 'map', expected 'world'" in said
    assert not list((tmp_path / "runs").rglob("checked.yaml"))
    assert not (tmp_path / "runs" / "latest").is_symlink()


@pytest.mark.parametrize(("answer", "goes"), [("y\n", True), ("\n", False)])
def test_it_asks_before_it_moves(monkeypatch, answer, goes):
    """While it waits the graph goes on: the answer comes at its third step."""
    reading, writing = os.pipe()
    steps = []

    def step():
        steps.append(len(steps))
        if len(steps) == 3:
            os.write(writing, answer.encode())
            os.close(writing)

    waiting = SimpleNamespace(step=step, preparation=SimpleNamespace(settings=Settings()), progress=Progress())
    with os.fdopen(reading) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        with nullcontext() if goes else pytest.raises(check.Declined):
            check.Check(waiting, yes=False).ask("move")
    assert len(steps) == 3


class Runaway:
    """A graph with a robot that goes at 1 m/s along x for as long as it is commanded to move, by a clock of the test's.

    Args:
        stall: once it has gone 0.1 m, a step takes so long [s].
    """

    def __init__(self, stall=0.0):
        self.node = SimpleNamespace(
            create_publisher=lambda *_: self,
            create_subscription=lambda kind, topic, take, profile, raw: self._takes(take),
        )
        self.pose, self.commanded = PoseRow(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), []
        self.recorder = SimpleNamespace(robot_waits="", held="", status=lambda name: DiagnosticStatus())
        self.preparation = SimpleNamespace(settings=PATIENT, robot=ROBOTS["sim"])
        self.listener, self.stepped = self, None
        self._time, self._stall = 0.0, stall

    def local_time(self):
        return self._time

    def spin_meanwhile(self):
        """Its poses come by steps alone."""

    def _takes(self, take):
        self._take = take

    def publish(self, command):
        self.commanded.append(command.linear.x)

    def step(self):
        self._time += 0.01
        if self.pose.x > 0.1:
            self._time += self._stall
            self._stall = 0.0
        # the thread that commands has its turn
        time.sleep(0.02)
        moves = bool(self.commanded and self.commanded[-1])
        self.pose = self.pose._replace(stamp=self._time, x=self.pose.x + (self._time - self.pose.stamp) * moves)
        self._take(serialize_message(state_to_odometry(self.pose.state, "map", "base_link")))


PATIENT = Settings().with_values({"limits.pose_age": 0.5, "limits.command_age": 0.5})


@pytest.mark.parametrize("limit", [0.1, 2.0])
def test_a_motion_ends_where_it_leads_too_far(limit):
    """Zero follows, as after any motion, and a robot that is far by then may still be commanded zero."""
    graph = Runaway()
    loop = OpenLoop(graph)
    with loop.commanding():
        loop.rest()
        poses = loop.drive((0.1, 0.0), 0.0, 0.5, lambda pose: pose.position[0] <= limit)
    assert graph.pose.x >= min(limit, 0.4)
    assert max(pose.position[0] for pose in poses) == pytest.approx(graph.pose.x, abs=0.1)
    moving = np.nonzero(graph.commanded)[0]
    assert np.array_equal(moving, np.arange(moving[0], moving[-1] + 1))
    assert len(graph.commanded) - moving[-1] > 5
    assert graph.pose.stamp > poses[-1].stamp + open_loop.HALTING_TIME - 0.02


@pytest.mark.parametrize(
    ("held", "waits", "said"),
    [
        ("no fresh command for 1.0 s", "held, ...: call resume", "may be too slow or too busy"),
        ("", "emergency stop by its service: call clear_estop", "emergency stop by its service"),
    ],
)
def test_a_robot_that_stands_ends_the_check_and_it_is_said_what_to_do(held, waits, said):
    graph = Runaway()
    loop = OpenLoop(graph)
    graph.recorder.held, graph.recorder.robot_waits = held, waits
    with pytest.raises(GraphError, match=said) as error, loop.commanding():
        loop.drive((0.1, 0.0), 0.0, 0.2, lambda pose: True)
    assert "resume" not in str(error.value)


def wait_for(condition):
    deadline = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.002)


class Stopwatch:
    """A clock that goes when it is told to, and the commands that were published until then."""

    def __init__(self):
        self.time, self.sent, self.allowed = 0.0, [], math.inf

    def now(self):
        return self.time

    def publish(self, command):
        self.sent.append(command)
        self.allowed = self.time + 0.055

    def paced(self):
        return PacedCommands(self.publish, 0.05, self.now, lambda: None)

    def run_until(self, end, condition=lambda: True):
        """Goes on by 10 ms at a time, as far as the next command is not due, and waits there for a condition."""
        while self.time < end:
            wait_for(lambda: self.time < self.allowed)
            self.time += 0.01
        wait_for(condition)

    @property
    def moves(self):
        return bool(self.sent and self.sent[-1].yaw_rate)


@pytest.mark.parametrize(("allowed", "ended"), [(9.0, 0.3), (0.15, 0.15)], ids=["by its time", "not allowed on"])
def test_a_motion_ends_by_itself(allowed, ended):
    """Whatever the thread that began it does meanwhile."""
    watch = Stopwatch()
    with watch.paced() as commands:
        wait_for(lambda: watch.sent)
        watch.run_until(0.02)
        motion = commands.begin(replace(stopped("check"), yaw_rate=1.0), 0.3, allowed)
        watch.run_until(0.1)
        assert watch.moves
        watch.run_until(0.5, lambda: not watch.moves)
        assert not watch.moves
    assert ended - 0.01 <= motion.ended <= 0.5
    assert motion.has_lapsed == (allowed < 0.3)


# ---- what the check makes of its figures

FINE = AxesFit(turn=0.1, uncertainty=0.005, scale=1.02, mirrored=False, robot_bias=0.01, bias_uncertainty=0.002)
TURNED = TurnFit(lever=np.array([0.03, -0.02]), uncertainty=0.0005, share=1.0, share_uncertainty=0.001)
SURE = np.array([0.001, 0.001, 0.001])
AHEAD = LidarMount(0.05, 0.0, 0.1, True)


def test_what_is_made_of_figures():
    quarter = replace(FINE, turn=-0.5 * math.pi)  # what the body sees ahead of it is to the robot's left
    far = replace(FINE, room_bias=0.2)
    for finding, verdict, text in (
        (axes_finding(FINE), GOOD, "1.020 +- 0.005 times"),
        (axes_finding(AxesFit(0.0, 0.1, 0.05, False)), WRONG, "not move"),
        (axes_finding(AxesFit(0.0, 0.1, 1.0, True)), WRONG, "left"),
        (axes_finding(AxesFit(0.0, 0.001, 1000.0, False)), WRONG, "mocap.units"),
        (axes_finding(AxesFit(0.0, 0.1, 0.6, False)), DOUBTFUL, "wheels"),
        (axes_finding(AxesFit(0.0, 0.001, 0.92, False)), GOOD, "0.920"),
        (turn_finding(replace(TURNED, share=0.99)), GOOD, ""),
        (turn_finding(replace(TURNED, share=0.8)), DOUBTFUL, ""),
        (turn_finding(replace(TURNED, share=-1.0)), WRONG, ""),
        (drift_finding(quarter, MotionEstimate(TURNED, quarter).offset), GOOD, "+0 mm/s ahead and +10 mm/s"),
        (drift_finding(far, MotionEstimate(TURNED, far).offset), DOUBTFUL, ""),
        (interruption_finding(Interruptions(40, 3)), GOOD, "3 of 40"),
        (interruption_finding(Interruptions(40, 8)), DOUBTFUL, "too busy"),
        (interruption_finding(Interruptions(9, 6)), WRONG, ""),
        (interruption_finding(Interruptions(5, 5)), GOOD, ""),
        (interruption_finding(Interruptions(9, 0, refused=6)), WRONG, "6 commands"),
        # seen 0.1 rad to the left of where it goes: the lever is turned by as much on the robot
        (offset_finding(MotionEstimate(TURNED, FINE)), GOOD, "+27.9 +- 0.5 mm ahead and -22.9 +- 0.5 mm left"),
        (offset_finding(MotionEstimate(TURNED, FINE)), GOOD, "-5.73 +- 0.29 deg"),
        (offset_finding(MotionEstimate(None, FINE)), DOUBTFUL, ""),
        (lidar_finding(MountFit(AHEAD, 0.97, 0.4, 0.01, SURE), 12), GOOD, "upside down"),
        (lidar_finding(MountFit(AHEAD, 0.97, 0.95, 0.01, SURE), 12), DOUBTFUL, "another place"),
        (lidar_finding(MountFit(AHEAD, 0.97, 0.4, 0.01, 20.0 * SURE), 12), DOUBTFUL, "+50.0 mm ahead"),
        (lidar_finding(MountFit(AHEAD, 0.4, 0.3, 0.01, SURE), 12), WRONG, "this room?"),
        (lidar_finding(None, 12), WRONG, "12 scans"),
    ):
        assert finding.verdict == verdict, finding
        assert text in finding.text


def test_verdicts_of_streams_and_nodes():
    for quality, verdicts in (
        (StreamQuality(100.0, 0.002, 0.02, 0.002), [GOOD, GOOD, GOOD]),
        (StreamQuality(20.0, 0.002, 0.06, 0.0001), [DOUBTFUL, GOOD, GOOD]),
        (StreamQuality(100.0, 0.05, 0.3, 0.01), [GOOD, WRONG, DOUBTFUL]),
    ):
        assert [finding.verdict for finding in stream_findings(quality, Settings())] == verdicts
    levels = {"/a": DiagnosticStatus.OK, "/b": DiagnosticStatus.WARN, "/c": DiagnosticStatus.ERROR}
    statuses = [DiagnosticStatus(level=level, name=name, message="so") for name, level in levels.items()]
    assert [f.verdict for f in node_findings(statuses)] == [GOOD, DOUBTFUL, WRONG]


FLOOR = """bounds: [0, 0, 2.6, 2.2]
polygons:
  - [[1.2, 0.2], [1.6, 0.2], [1.6, 0.5], [1.2, 0.5]]
  - [[0.1, 1.3], [0.3, 1.3], [0.3, 1.8], [0.1, 1.8]]
"""
MOUNTED = {"offset_x": 0.05, "offset_y": -0.02, "offset_yaw": 2.0, "mirrored": True}


def lidar_scans(world, **values):
    """What listens during a check, and what it listens with."""
    taken = []
    node = SimpleNamespace(create_subscription=lambda kind, topic, take, profile: taken.append(take))
    preparation = SimpleNamespace(settings=Settings().with_values(values), world=world)
    return LidarScans(SimpleNamespace(node=node, local_time=time.monotonic), preparation), taken[0]


def test_the_place_of_the_lidar_is_found_from_messages_of_any_frame():
    """The body's poses are 3 cm off the robot's, and what is believed of the LIDAR before does not mislead it."""
    world, random = parse_text(FLOOR, "floor", "floor"), np.random.default_rng(0)
    scans, take = lidar_scans(world, **{"scan.frame": "base_laser", "scan.offset_x": 0.5, "scan.mirrored": True})
    offset, body = BodyOffset(0.03, 0.0, 0.2), []
    for step in range(60):
        turning = 0.0 if step < 40 else 0.05 * (step - 40)
        at = np.array([0.9, 0.9]) + random.normal(0.0, 0.002, 2)
        body.append(with_offset(PoseSample(0.05 * step, at, 0.7 + turning), offset.x, offset.y, offset.yaw))
        state = State(0.05 * step, np.array([0.9, 0.9]), np.zeros(2), 0.7 + turning)
        take(scan_to_message(simulate_scan(world, state, Lidar(n_beams=120, **MOUNTED)), "laser"))
    finding, found = scans.find(body, offset)
    assert finding.verdict == GOOD, finding.text
    assert (found["scan.mirrored"], found["scan.frame"]) == (True, "laser")
    assert found["scan.offset_x"] == pytest.approx(0.05, abs=0.003)
    assert found["scan.offset_y"] == pytest.approx(-0.02, abs=0.003)
    assert found["scan.offset_yaw"] == pytest.approx(2.0, abs=math.radians(0.3))
    Settings().with_values(found)


def test_scans_by_another_clock_are_said():
    """By what planner and controller refuse them for: limits.scan_age and limits.pose_age."""
    scans, take = lidar_scans(parse_text(FLOOR, "floor", "floor"))
    assert scans.coming([], []).verdict == WRONG
    state = State(10.0, np.array([0.9, 0.9]), np.zeros(2), 0.0)
    take(scan_to_message(simulate_scan(parse_text(FLOOR, "floor", "floor"), state, Lidar(n_beams=60)), "laser"))
    never = PoseSample(99.0, np.zeros(2), 0.0)
    for late, verdict, text in (
        (0.0, GOOD, "0 ms after"),
        (0.2, GOOD, "200 ms after"),
        (3.2, WRONG, "3.20 s after"),
        (-0.1, GOOD, "-100 ms after"),
        (-0.3, WRONG, "0.30 s before"),
    ):
        finding = scans.coming([PoseSample(10.0 + late, np.zeros(2), 0.0), never], [0.0, math.inf])
        assert finding.verdict == verdict, late
        assert text in finding.text
    found, values = scans.find([PoseSample(13.0 + 0.01 * k, np.zeros(2), 0.0) for k in range(50)], BodyOffset(0, 0, 0))
    assert (found.verdict, values) == (WRONG, {})
    assert "13.49 s" in found.text


def test_what_is_found_beside_something_wrong_is_written_and_the_exit_code_says_so(tmp_path, capsys, monkeypatch):
    prepared = SimpleNamespace(settings=Settings(), programs={})
    monkeypatch.setattr(check, "_prepared", lambda options: prepared)
    graph = SimpleNamespace(preparation=prepared, progress=Progress())
    monkeypatch.setattr(check, "Graph", lambda *_: nullcontext(graph))
    monkeypatch.setattr(check.Check, "run", lambda self: ({"mocap.body_offset_x": 0.01}, False))
    assert main(["--check", "--yes", "--out", str(tmp_path / "runs")]) == 1
    assert read_parameters(tmp_path / "runs" / "latest" / "checked.yaml") == {"mocap.body_offset_x": 0.01}
    assert "drive with" not in capsys.readouterr().out
