"""The driver and the emulated firmware behind a pseudo-terminal, in the test's own process."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, EVENT, LATCHED, NEWEST
from omnipuck_driver.driver_node import DriverNode
from omnipuck_driver.messages import ESTOP_LATCHED
from omnipuck_sim.emulator.firmware_emulator import FirmwareEmulator

HALL = """
bounds: [-1.0, -3.0, 20.0, 3.0]
walled: true
start: [0.0, 0.0]
"""


def twist(x: float = 0.0, y: float = 0.0, yaw_rate: float = 0.0) -> Twist:
    message = Twist()
    message.linear.x, message.linear.y, message.angular.z = x, y, yaw_rate
    return message


@contextmanager
def let_move(ros) -> Iterator[None]:
    """Somebody calls resume as long as the robot is held, again where that is refused."""
    client = ros.probe.create_client(Trigger, "resume")
    assert ros.wait_until(client.service_is_ready, 60.0)
    states: list[str] = []

    def take(state: DiagnosticStatus) -> None:
        states.append(next(item.value for item in state.values if item.key == "state"))

    def resume() -> None:
        if states and states[-1] == "held":
            client.call_async(Trigger.Request())

    subscription = ros.probe.create_subscription(DiagnosticStatus, "robot/state", take, LATCHED)
    timer = ros.probe.create_timer(0.05, resume)
    assert ros.wait_until(lambda: states and states[-1] == "free", 60.0), states
    yield
    ros.probe.destroy_timer(timer)
    ros.probe.destroy_subscription(subscription)
    ros.probe.destroy_client(client)


class SerialRobot:
    def __init__(self, ros, folder: Path, **parameters) -> None:
        self.ros = ros
        world = folder / "hall.yaml"
        world.write_text(HALL)
        line = str(folder / "serial")
        own = {"simulator.world": str(world), "simulator.noise": 0.0, "driver.port": line, "emulator.link": line}
        self.parameters = {**own, **parameters}
        self.reports: dict[str, DiagnosticStatus] = {}
        self.odometry = ros.listen(Odometry, "ground_truth/odom", EVENT)
        ros.probe.create_subscription(DiagnosticArray, "/diagnostics", self._take_report, DIAGNOSTICS_SUBSCRIBED)
        self.emulator = ros.make(FirmwareEmulator, self.parameters)
        self.driver = ros.make(DriverNode, self.parameters)
        self.commands = ros.probe.create_publisher(Twist, "cmd_vel", NEWEST)

    def _take_report(self, message: DiagnosticArray) -> None:
        self.reports.update({status.name: status for status in message.status})

    def until(self, condition: Callable[[], object], timeout: float = 60.0) -> None:
        assert self.ros.wait_until(condition, timeout), f"waited in vain; {self.said}"

    def ready(self) -> None:
        self.until(lambda: not self.driver.link.trouble() and self.commands.get_subscription_count() > 0)

    def go_until(self, condition: Callable[[], object], **velocity) -> None:
        """As `drive_until`, with a person who lets the robot move, again where a stall of the test has held it."""
        with let_move(self.ros):
            self.drive_until(condition, **velocity)

    def drive_until(self, condition: Callable[[], object], **velocity) -> None:
        """Sends the command at 20 Hz until the condition holds."""
        message = twist(**velocity)
        timer = self.ros.probe.create_timer(0.05, lambda: self.commands.publish(message))
        self.commands.publish(message)
        self.until(condition)
        self.ros.probe.destroy_timer(timer)

    def ask(self, faults: str) -> None:
        (result,) = self.emulator.set_parameters([Parameter("emulator.faults", value=faults)])
        assert result.successful, result.reason

    def call(self, name: str) -> Trigger.Response:
        return self.ros.call(Trigger, name)

    def value(self, node: str, key: str) -> str:
        return next((v.value for v in self.reports[f"/{node}"].values if v.key == key), "")

    @property
    def said(self) -> dict[str, str]:
        return {name: status.message for name, status in self.reports.items()}

    @property
    def speed(self) -> float:
        linear = self.odometry[-1].twist.twist.linear if self.odometry else Twist().linear
        return (linear.x**2 + linear.y**2) ** 0.5

    @property
    def stop_latched(self) -> bool:
        telemetry = self.driver.link.session.telemetry
        return telemetry is not None and bool(telemetry.status & ESTOP_LATCHED)

    @property
    def stops(self) -> int:
        return int(self.value("firmware_emulator", "stops"))

    @property
    def stalled(self) -> float:
        """Time for which this process was held up, by the emulator's clock [s]."""
        return float(self.value("firmware_emulator", "time_stalled"))

    @property
    def state(self) -> str:
        return str(self.driver.contract.counts["state"])

    @property
    def stop_cause(self) -> str:
        return self.value("firmware_emulator", "stop_cause")
