"""The simulated robot in a room with motion capture: its poses, and the truth, on the graph."""

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from math import floor
from time import monotonic

from geometry_msgs.msg import PoseStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import MarkerArray

from collplan_core.clock_steps import ClockOffset
from collplan_core.impact import Impact
from collplan_core.parameters import ParameterError, Settings, Simulation
from collplan_core.poses.pose_filter import PoseSample
from collplan_core.worlds import load_world
from collplan_ros.messages.conversions import impact_to_message, pose_to_message, stamp_from_seconds, state_to_odometry
from collplan_ros.messages.mover_markers import movers_to_markers
from collplan_ros.messages.planner_clouds import impact_to_cloud
from collplan_ros.messages.qos import EVENT, NEWEST, POSE_PUBLISHED
from collplan_ros.node_kit.clock import call_in, seconds, steady_clock
from collplan_ros.node_kit.node_parameters import on_change
from omnipuck_sim.node.pacing import Pacing
from omnipuck_sim.robot.noise import added_latency, faulty
from omnipuck_sim.robot.physics import Simulator

MOCAP_LIVE = ("simulator.mocap_fault",)
"""Parameters of the room that may change while its node runs."""
FASTEST_TIMER = 0.001
"""Shortest period of the timer; what is due between two calls is then published together [s]."""
LATE = 1e-4
"""Time after a pose is due at which the timer comes [s]."""
CATCH_UP = 5.0
"""Simulated time that is made up for after a stall where stamps are those of the system's clock [s]."""
CATCH_UP_OF_CLOCK = 0.05
"""The same where /clock is published, and everything else waits for it [s]."""


class SimulatedMocap:
    """Runs in real time, stamped by the system's clock; or in simulated time, which it publishes on /clock.

    Time passes by the local clock from `start` on, or else pose by pose, whenever `grant` is called.
    """

    def __init__(self, node: Node, settings: Settings) -> None:
        """Publishes through `node`."""
        simulation = settings.simulator
        world = load_world(simulation.world)
        self.simulator = Simulator(world, settings, simulation.seed)
        self.publishes_clock = simulation.publishes_clock  # time is the simulator's, for all nodes
        x, y = self.simulator.state.position.tolist()
        self.description = f"world {world.name}, seed {simulation.seed}, start {x:.3f}, {y:.3f}"
        self.impacts = 0  # so far
        self._node = node
        self._settings = settings
        self._fault = simulation.mocap_fault
        on_change(node, self._take_fault, Simulation)
        catch_up = CATCH_UP_OF_CLOCK if self.publishes_clock else CATCH_UP
        self._pacing = Pacing(simulation.physics_rate, simulation.speed_factor, catch_up, monotonic())
        self._offset = ClockOffset(lambda: seconds(node.get_clock()), monotonic)
        self._epoch = 0.0
        self._poses = 0
        self._measured: PoseSample | None = None
        self._unsent: deque[tuple[float, PoseStamped]] = deque()
        self._pose_publisher = node.create_publisher(PoseStamped, "mocap/pose", POSE_PUBLISHED)
        self._odometry_publisher = node.create_publisher(Odometry, "ground_truth/odom", EVENT)
        self._impact_publisher = node.create_publisher(Vector3Stamped, "ground_truth/impact", EVENT)
        self._contact_publisher = node.create_publisher(PointCloud2, "ground_truth/impact/contact", EVENT)
        self._mover_publisher = node.create_publisher(MarkerArray, "ground_truth/movers", EVENT)
        self._clock_publisher = node.create_publisher(ClockMessage, "/clock", NEWEST) if self.publishes_clock else None

    def start(self, advance: Callable[[], object]) -> None:
        """Calls `advance` once per pose, when due by the local clock; ParameterError: simulator.speed_factor is 0."""
        simulation = self._settings.simulator
        if simulation.speed_factor == 0.0:
            raise ParameterError("simulator.speed_factor: got 0, expected more: only bringup makes time wait for nodes")
        period = max(1.0 / (simulation.mocap_rate * simulation.speed_factor), FASTEST_TIMER)

        def look() -> None:
            advance()
            # a timer that keeps its own time comes a little before the pose, and then a period late
            left = self._until_next_pose / simulation.speed_factor + LATE
            call_in(timer, round(1e9 * min(max(left, FASTEST_TIMER), period)))

        timer = self._node.create_timer(period, look, clock=steady_clock())

    @property
    def _until_next_pose(self) -> float:
        """Simulated time until a pose is due, less that which has passed by the clock already [s]."""
        due = (self._poses + 1) / self._settings.simulator.mocap_rate
        return due - self.simulator.time - self._pacing.behind

    @property
    def stalled(self) -> float:
        """Time for which this process was held up so far [s]."""
        return self._pacing.stalled

    def advance(self, before_step: Callable[[], None] | None = None) -> list[Impact]:
        """Brings the simulation to the present, publishes poses and impacts on the way, and returns the impacts."""
        now = monotonic()
        steps = self._pacing.due(now)
        if not self.publishes_clock:
            self._offset.compare()
            present = self.simulator.time + steps / self._settings.simulator.physics_rate + self._pacing.behind
            self._epoch = now + self._offset.ahead - present
        for _ in range(steps):
            if before_step is not None:
                before_step()
            self._step()
        return self._publish_impacts()

    def grant(self) -> None:
        """Lets simulated time pass until a pose has been measured or sent."""
        while not self._step():
            pass
        self._publish_impacts()

    def _step(self) -> bool:
        """Takes a step; returns whether a pose was measured or sent in it."""
        self.simulator.step()
        measures, sends = self._measures_pose(), self._sends_pose()
        if (measures or sends) and self._clock_publisher is not None:
            self._clock_publisher.publish(ClockMessage(clock=stamp_from_seconds(self.simulator.time)))
        if measures:
            self._measure_pose()
        self._send_poses()
        return measures or sends

    def _publish_impacts(self) -> list[Impact]:
        impacts = self.simulator.take_impacts()
        for impact in impacts:
            stamped, frame = replace(impact, time=self._epoch + impact.time), self._settings.frames.map
            self._impact_publisher.publish(impact_to_message(stamped.time, impact.change, frame))
            self._contact_publisher.publish(impact_to_cloud(stamped, frame))
        self.impacts += len(impacts)
        return impacts

    def _take_fault(self, settings: Settings) -> None:
        self._fault = settings.simulator.mocap_fault

    def _measures_pose(self) -> bool:
        due = floor(self.simulator.time * self._settings.simulator.mocap_rate + 1e-6)
        before, self._poses = self._poses, max(due, self._poses)
        return due > before

    def _sends_pose(self) -> bool:
        return bool(self._unsent) and self._unsent[0][0] <= self._half_a_step_later

    @property
    def _half_a_step_later(self) -> float:
        # of tolerance: sums of decimal times must not decide
        return self.simulator.time + 0.5 / self._settings.simulator.physics_rate

    def _measure_pose(self) -> None:
        frames, stamp = self._settings.frames, self._epoch + self.simulator.time
        self._measured = faulty(self.simulator.measured_pose(), self._fault, self._measured)
        later = self._settings.simulator.mocap_latency + added_latency(self._fault, self.simulator.time)
        sent = replace(self._measured, stamp=self._epoch + self._measured.stamp)
        self._unsent.append((self.simulator.time + later, pose_to_message(sent, frames.map)))
        movers = self.simulator.movers
        if len(movers):
            self._mover_publisher.publish(movers_to_markers(stamp, movers, frames.map))
        truth = replace(self.simulator.state, stamp=stamp)
        self._odometry_publisher.publish(state_to_odometry(truth, frames.map, frames.base, self.simulator.spin))

    def _send_poses(self) -> None:
        while self._sends_pose():
            self._pose_publisher.publish(self._unsent.popleft()[1])
