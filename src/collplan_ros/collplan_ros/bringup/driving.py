"""One run on the graph: starts it, waits until it is ready, gives goals, monitors how they end, and reports why."""

import math
import os
import time
from collections import Counter
from collections.abc import Callable
from itertools import cycle

import numpy as np
from action_msgs.msg import GoalStatus
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter

from collplan_core.control.runaway import MOVES
from collplan_core.evaluation import run_end
from collplan_core.evaluation.run_end import (
    ABORTED,
    CANCELED,
    REACHED,
    STUCK,
    TIMEOUT,
    RunMonitor,
    drive_noise_hint,
    pace_words,
)
from collplan_ros.bringup import complaints
from collplan_ros.bringup.complaints import seen_more_than
from collplan_ros.bringup.failures import DrivesOn, GraphError, Interrupted, StartError
from collplan_ros.bringup.graph import LATE, NOTICE_TIME, Graph
from collplan_ros.bringup.lidar_place import with_lidar_place
from collplan_ros.bringup.listener import NAME, REST_PATIENCE
from collplan_ros.bringup.options import COMMANDER, PLANNER, Options
from collplan_ros.bringup.preparation import prepare
from collplan_ros.bringup.progress import Progress, in_words
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.messages.states import NUMBERS
from collplan_ros.messages.status_values import values_of
from collplan_ros.node_kit.diagnostics import ERROR
from collplan_ros.node_kit.reachability import SERVER
from collplan_ros.run.recorder import GoalReport
from collplan_ros.run.run_log import PoseRow
from collplan_ros.run.whole_file import RecordError

READY_PATIENCE = 300.0
"""Longest wait for the nodes to report; they may have to compile first [s]."""
LINK_PATIENCE = 3.0
"""Longest wait for the robot's link, once every node has reported [s]."""


def wait_until_ready(graph: Graph) -> None:
    """Waits until every node has reported, poses and scans come, and the planner listens for a goal.

    Raises:
        NodeDied, GraphError, Interrupted, RecordError: as methods of the graph.
    """
    robot, recorder, says = graph.preparation.robot.nodes[0], graph.recorder, graph.complaints
    graph.wait(_all_reported(graph), READY_PATIENCE, lambda: says.unready(READY_PATIENCE))
    graph.let_time_run()
    twice = seen_more_than(graph.listener.node, Counter([NAME, *graph.preparation.programs]))
    if twice:
        raise GraphError(says.not_alone(f"another {in_words(twice)}"))
    status = recorder.status
    graph.wait(lambda: status(robot).level != ERROR, LINK_PATIENCE, lambda: f"{robot}: {status(robot).message}")
    if values_of(status(robot)).get("impact_sensing") == "yes":
        # else each impact would be published twice
        off = Parameter("mocap.detect_impacts", value=False).to_parameter_msg()
        service = f"{graph.preparation.full_name('mocap_node')}/set_parameters"
        graph.call(SetParameters, service, SetParameters.Request(parameters=[off]))
    # a goal is new to the robot, and lets it move, only after it has received something from the planner
    for condition, complaint in (
        (lambda: recorder.newest is not None, says.no_pose),
        (lambda: recorder.scan_came, says.no_scan),
        (lambda: graph.goals.are_heard, says.no_planner),
        (lambda: recorder.robot.get("knows_planner") == "yes", lambda: says.missing("robot/state", "reliable")),
    ):
        graph.wait(condition, complaints.INPUT_PATIENCE, complaint)
    graph.is_ready = True
    graph.step()


def refuse_kept_stop(graph: Graph) -> None:
    """Raises GraphError where the robot has kept an emergency stop: it must not drive off when somebody clears that."""
    if why := graph.recorder.emergency_stop:
        clear = graph.complaints.name("clear_estop")
        raise GraphError(f"{why}: call {clear}, or press Clear emergency stop on the page, then start again")


def _all_reported(graph: Graph) -> Callable[[], bool]:
    notice = time.monotonic() + NOTICE_TIME

    def condition() -> bool:
        nonlocal notice
        silent = graph.complaints.silent_nodes
        if silent and time.monotonic() > notice:
            served = f"; {SERVER} is set: only by its server they meet" if os.environ.get(SERVER) else ""
            why = "slow on a busy machine, or before the first compile"
            graph.progress.say(f"waiting for {in_words(silent)} ({why}{served})")
            notice = math.inf
        return not silent

    return condition


OUTCOMES = {NUMBERS[status]: outcome for status, outcome in run_end.OUTCOMES.items()}
"""Outcome of a run by the final status of its goal, one of GoalStatus.STATUS_*."""


def outcome_of(goal: GoalReport | None, pose: PoseRow, maneuver: str, monitor: RunMonitor) -> str | None:
    """Outcome of a run at its newest pose and maneuver, None while it goes on.

    The planner's report of the goal's end has priority over the monitor, however old the pose. A report is used
    only once the poses sent before it were taken: time counts from the first of those after the first plan, and the
    time of arrival is read from them.
    """
    monitor.commanded(maneuver)
    final = goal is not None and goal.status in OUTCOMES
    if goal is not None and goal.sent <= pose.sent:
        if final:
            return OUTCOMES[goal.status]
        if goal.status == GoalStatus.STATUS_EXECUTING:
            monitor.executing(pose.stamp)
    return None if final else monitor.outcome(pose.stamp, np.array([pose.x, pose.y]))


EMERGENCY_STOP = "emergency_stop"
"""Outcome of a run in which the robot's emergency stop was latched."""
BY_A_PERSON = (CANCELED, EMERGENCY_STOP)
"""Outcomes after which the robot stands until a person gives a goal."""
PAUSE = 1.0
"""Rest at each end of a lap [s]."""
MONITORED = (TIMEOUT, STUCK)
"""Outcomes that no node reports."""
BROKEN_OFF = (GraphError, Interrupted, RecordError)
"""Exceptions that end a run before its outcome."""
CANCEL_PERIOD = 0.1
"""Period at which the planner is asked to end the goal, until it has [s]: it may not be discovered yet."""
CANCEL_PATIENCE = 0.3
"""Longest wait for the end of a goal that was canceled [s]."""
ACTIVE = (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING)
"""Status of a goal that the robot is on the way to."""


class Bringup:
    """One run, a context manager: entering starts the graph, leaving stops it.

    Most scripts need only `run()`; this class is for those that act during the run. Use it in a thread that lives as
    long as the graph: the nodes are killed when the thread that started them ends.

    Attributes:
        options: what is asked for.
        lidar_place: where a real LIDAR is on the robot, and how that is known, in words; empty where parameters say it.

    Raises:
        StartError: the request cannot be fulfilled; nothing was started.
        NodeDied, GraphError, Interrupted, RecordError: from every method that waits.
    """

    def __init__(self, options: Options, progress: Progress | None = None) -> None:
        """Checks everything and makes the run folder."""
        self.options, self.progress = options, progress or Progress()
        self.preparation, self.lidar_place = with_lidar_place(prepare(options))
        self.folder = RunFolder(options.out, self.preparation.settings)
        self.graph = Graph(self.preparation, self.folder, self.progress)
        self._why = ""

    def __enter__(self) -> "Bringup":
        try:
            self.graph.__enter__()
            if why := self.folder.become_latest():
                self.progress.say(why)
        except StartError:
            self.graph.__exit__()
            self.folder.discard()
            raise
        except BROKEN_OFF as error:
            self.progress.say(str(error))
            raise
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, BROKEN_OFF):  # at once: to stop the nodes takes some seconds
            self.progress.say(str(error))
        try:
            self.graph.__exit__(kind, error, trace)
        except RecordError as lost:  # the last lines do not fit on the disk
            self.progress.say(str(lost))
            raise

    def drive_laps(self, ends: list[np.ndarray], say: Callable[[str], None]) -> None:
        """Drives from end (2,) [m] to end until an exception ends it: a signal or an error.

        A person may give goals in between. Where one cancels, or stops the robot, it stands until one gives a goal.
        """
        for target in cycle(ends):
            outcome = self.drive(target)
            self.come_to_rest()
            if outcome in BY_A_PERSON:
                say(f"{outcome.replace('_', ' ')}: the robot stands until you give it a goal")
                self.wait(lambda: self.goal_is_active)
                self.wait(lambda: not self.goal_is_active)
            elif outcome != REACHED:
                say(self.reason(outcome))
            end = self.graph.now() + PAUSE
            self.wait(lambda: self.graph.now() > end)  # noqa: B023 (called in this lap)

    def drive(self, goal: np.ndarray | None = None) -> str:
        """Gives the goal (2,) [m], the prepared one by default, and monitors the run.

        Returns:
            The outcome: reached, aborted or canceled by the planner's report, else timeout, stuck or emergency_stop.
        """
        target = self.preparation.goal if goal is None else goal
        graph = self.graph
        graph.recorder.begin(self.preparation.robot.simulated)
        graph.give_goal(target)
        monitor = RunMonitor(self.preparation.settings.trial, graph.pose.stamp)
        recorder = graph.recorder
        while True:
            outcome = outcome_of(recorder.goal, graph.pose, recorder.maneuver, monitor)
            if outcome in MONITORED and recorder.lateness > LATE:
                graph.catch_up()  # poses arrived too late to show it
                continue
            if outcome is not None:
                break
            if recorder.emergency_stop:
                self.progress.say(self.reason(EMERGENCY_STOP))
                return EMERGENCY_STOP
            self._show_progress(target)
            graph.step()
        # now: what ends the goal makes the controller stand for that reason
        self._why = f"{outcome}: {self._why_not_there(monitor.reason)}"
        return outcome

    def _show_progress(self, target: np.ndarray) -> None:
        pose, recorder = self.graph.pose, self.graph.recorder
        begin = recorder.time_zero
        # a pose of a while ago is not where the robot is now
        if begin is not None and pose.stamp >= begin and recorder.age <= LATE:
            distance = float(np.hypot(pose.x - target[0], pose.y - target[1]))
            pace = pace_words(recorder.real_time_factor)
            self.progress.show(pose.stamp - begin, distance, recorder.maneuver, recorder.n_impacts, pace)

    def come_to_rest(self) -> None:
        """Cancels a goal that has not ended, and waits until it has and the robot rests, at most REST_PATIENCE.

        A goal that has not ended within CANCEL_PATIENCE is not waited for: leave the graph then, which stops the robot.

        Raises:
            DrivesOn: it does not rest.
        """
        graph, begun = self.graph, self.graph.now()
        due = begun
        while (now := graph.now()) < begun + REST_PATIENCE:
            if self._goal_has_ended and graph.listener.at_rest:
                return
            if not self._goal_has_ended:
                if now > begun + CANCEL_PATIENCE:
                    return
                if now >= due:
                    graph.goals.cancel()
                    due = now + CANCEL_PERIOD
            graph.step()
        if (speed := graph.listener.speed) > MOVES:
            raise DrivesOn(f"the robot drives on at {speed:.2f} m/s, {now - begun:.0f} s after the end of its run")

    def wait(self, condition: Callable[[], bool]) -> None:
        """Lets the graph run until a condition holds."""
        while not condition():
            self.graph.step()

    @property
    def goal_is_active(self) -> bool:
        """True where the robot is on the way to a goal, whoever gave it."""
        goal = self.graph.recorder.goal
        return goal is not None and goal.status in ACTIVE

    @property
    def _goal_has_ended(self) -> bool:
        goal = self.graph.recorder.goal
        return goal is None or goal.status in OUTCOMES

    def reason(self, outcome: str) -> str:
        """Returns why the goal was not reached, for the outcome of `drive`; the planner's report may come after it."""
        if outcome == ABORTED:
            return self.graph.recorder.status(PLANNER).message + self.graph.complaints.frozen + self._noise_hint
        if outcome == EMERGENCY_STOP:
            return self.graph.recorder.emergency_stop
        return self._why + self._noise_hint if outcome in MONITORED else ""

    @property
    def _noise_hint(self) -> str:
        return drive_noise_hint(self.preparation.settings) if self.preparation.robot.simulated else ""

    def _why_not_there(self, monitored: str) -> str:
        """Returns why the robot is not at the goal: a hold first, then a standing controller, then the planner."""
        recorder, frozen = self.graph.recorder, self.graph.complaints.frozen
        if recorder.held:
            return f"the robot is held: {recorder.held}{frozen}"
        planner = f"{PLANNER}: {recorder.status(PLANNER).message}"
        return f"{monitored}{frozen}; {f'{COMMANDER}: {recorder.standing}' if recorder.standing else planner}"
