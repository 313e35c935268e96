"""What the nodes around planner and controller write to the terminal, and that they compare their constants."""

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from serial_robot import SerialRobot
from std_srvs.srv import Trigger
from terminal import INFO, WARN, Terminal

from collplan_core.sensing.pose_filter import PoseSample
from collplan_ros.messages.conversions import pose_to_message
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, POSE_PUBLISHED
from collplan_ros.nodes.lidar_node import LidarNode
from collplan_ros.nodes.mocap_node import MocapNode
from omnipuck_sim.node.simulator_node import SimulatorNode

STOPPED = "emergency stop by its service: commands are ignored until it is cleared (clear_estop)"
CLEARED = "held, after the emergency stop: give a new goal, or call resume"


@pytest.fixture
def terminal(ros):
    return Terminal(ros)


@pytest.fixture
def robot(ros, terminal, tmp_path):
    """Driver and emulated firmware that have found each other."""
    robot = SerialRobot(ros, tmp_path)
    robot.ready()
    return robot


def count(lines, said):
    return sum(text == said for _, text in lines)


def test_nodes_in_any_order_say_what_they_wait_for_and_when_it_comes(ros, terminal):
    lidar = ros.make(LidarNode, {"lidar.world": "slalom"})
    terminal.says(lidar, INFO, "ready: listens to mocap/odom; world slalom, 360 beams at 20 Hz")
    terminal.says(lidar, WARN, "no mocap/odom: 0 publishers")
    mocap = ros.make(MocapNode)
    terminal.says(mocap, INFO, "ready: listens to mocap/pose; format pose, frame map")
    terminal.says(mocap, WARN, "no mocap/pose: 0 publishers")
    terminal.says(lidar, WARN, "no mocap/odom: 1 publisher, nothing received")
    simulator = ros.make(
        SimulatorNode, {"simulator.world": "slalom", "simulator.seed": 3, "simulator.start_noise": 0.0}
    )
    terminal.says(simulator, INFO, "ready: listens to cmd_vel, goal_status; world slalom, seed 3, start 0.250, 0.300")
    terminal.says(simulator, INFO, "waits for cmd_vel")
    terminal.says(mocap, INFO, "mocap/pose comes")
    terminal.says(lidar, INFO, "mocap/odom comes")


def test_stop_clear_and_reset_of_the_simulated_robot(ros, terminal):
    node = ros.make(SimulatorNode)
    for name in ("estop", "estop", "clear_estop", "reset"):
        ros.call(Trigger, name)
    terminal.says(node, INFO, "reset: back at the start, at rest")
    own = [line for line in terminal.lines(node) if "stop" in line[1]]
    assert own == [(WARN, STOPPED), (WARN, CLEARED)]


def test_the_button_and_the_service_of_the_real_robot(ros, terminal, robot):
    button = "emergency stop by the button on the robot: commands are ignored until it is cleared (clear_estop)"
    terminal.says(robot.driver, INFO, f"ready: listens to cmd_vel, goal_status; {robot.path} at 115200 bit/s, 3 wheels")
    terminal.says(robot.driver, INFO, "connected, the firmware answers commands")
    robot.ask(estop_pressed=True)
    terminal.says(robot.driver, WARN, button)
    terminal.says(robot.emulator, WARN, "the emergency stop on the robot is pressed")
    robot.call("clear_estop")
    still = "the emergency stop on the robot is still pressed: release it first"
    terminal.says(robot.driver, WARN, f"emergency stop not cleared: {still}")
    robot.ask(estop_pressed=False)
    robot.until(lambda: not robot.driver._link.session.button_pressed)
    terminal.says(robot.emulator, INFO, "the emergency stop on the robot is released")
    robot.call("clear_estop")
    terminal.says(robot.driver, WARN, CLEARED)
    robot.call("estop")
    terminal.says(robot.driver, WARN, STOPPED)
    assert count(terminal.lines(robot.driver), button) == 1


def test_a_ring_that_senses_impacts_needs_poses(ros, terminal, tmp_path):
    robot = SerialRobot(ros, tmp_path, **{"emulator.senses_impacts": True})
    terminal.says(robot.driver, WARN, "no mocap/odom: 0 publishers")
    ros.make(MocapNode, {"mocap.accept_frozen": True})
    robot.until(lambda: any(text.startswith("mocap/odom comes") for _, text in terminal.lines(robot.driver)))


def test_the_firmware_that_stops_the_robot_by_itself_is_told(terminal, robot):
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    robot.ask(unplugged=True)
    robot.until(lambda: robot.stop_cause == "life")
    robot.ask(unplugged=False)
    terminal.says(robot.driver, WARN, "stopped by the firmware: the last command outlived its life")
    assert any(text.startswith("stopped, cause: life") for _, text in terminal.lines(robot.emulator))


def test_a_loose_cable_fills_no_terminal(ros, terminal, robot):
    terminal.says(robot.driver, INFO, "connected, the firmware answers commands")
    begun = len(terminal.times(robot.driver))  # what is said at the start is none of it
    for k in range(40):
        robot.ask(unplugged=k % 2 == 0)
        ros.spin(0.1)
    times = terminal.times(robot.driver)[begun:]
    assert times
    for start in times:
        assert sum(start <= time < start + 3.0 for time in times) <= 5, terminal.lines(robot.driver)


def test_a_body_that_holds_its_last_pose_is_refused_at_the_terminal(ros, terminal):
    mocap = ros.make(MocapNode)
    poses = ros.publisher(PoseStamped, "mocap/pose", POSE_PUBLISHED)
    stamps = iter(0.01 * k for k in range(100000))
    ros.probe.create_timer(
        0.01, lambda: poses.publish(pose_to_message(PoseSample(next(stamps), np.zeros(2), 0.0), "map"))
    )
    terminal.says(mocap, WARN, "mocap/pose refused: frozen: nothing but the same pose (mocap.accept_frozen: false)")


def test_nodes_that_disagree_warn_on_diagnostics(ros):
    health = {}

    def take(message):
        health.update({status.name: status for status in message.status})

    ros.probe.create_subscription(DiagnosticArray, "/diagnostics", take, DIAGNOSTICS_SUBSCRIBED)

    def message_of(name):
        return health[name].message if name in health else ""

    ros.make(SimulatorNode, {"robot.radius": 0.15})
    ros.make(MocapNode)
    ros.make(LidarNode)  # has no robot.*
    assert ros.wait_until(lambda: "robot.radius: 0.15 here, 0.09 in /mocap_node" in message_of("/simulator_node"))
    assert ros.wait_until(lambda: "robot.radius: 0.09 here, 0.15 in /simulator_node" in message_of("/mocap_node"))
    assert health["/simulator_node"].level == health["/mocap_node"].level == b"\x01"
    assert ros.wait_until(lambda: health["/lidar_node"].level == b"\x00")
