"""One run on the graph: starts it, waits until it is ready, gives goals, watches how they end, and tells why."""

import os
from itertools import cycle

import numpy as np
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter

from collplan_core.control.runaway import MOVES
from collplan_core.evaluation.run_end import ABORTED, REACHED, RunMonitor, drive_noise_hint, pace_words
from collplan_core.loop.mover_guard import sight_hint
from collplan_ros.bringup import ending, watching
from collplan_ros.bringup.graph import Graph
from collplan_ros.bringup.options import COMMANDER, PLANNER, Options
from collplan_ros.bringup.preparation import prepare, with_lidar_place
from collplan_ros.bringup.progress import Progress, in_words
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.bringup.watching import REST_PATIENCE
from collplan_ros.messages.status_values import values_of
from collplan_ros.node_kit.diagnostics import ERROR
from collplan_ros.node_kit.reachability import SERVER
from collplan_ros.run.whole_file import RecordError

READY_PATIENCE = 300.0  # longest wait for the nodes to report; they may have to compile first [s]
LINK_PATIENCE = 3.0  # longest wait for the robot's link, once every node has reported [s]


def wait_until_ready(graph: Graph) -> None:
    """Waits until every node has reported, poses and scans come, and the planner listens for a goal."""
    robot, recorder, says = graph.preparation.robot.nodes[0], graph.recorder, graph.complaints

    def waited_for() -> str:
        served = f"; {SERVER} is set: only by its server they meet" if os.environ.get(SERVER) else ""
        why = "slow on a busy machine, or before the first compile"
        return f"waiting for {in_words(silent)} ({why}{served})" if (silent := says.silent_nodes) else ""

    def unready() -> str:
        late = f"{in_words(says.silent_nodes)} not ready within {READY_PATIENCE:g} s"
        return f"{late}: nothing on /diagnostics; {graph.preparation.where}"

    with graph.notice(waited_for):
        graph.wait(lambda: not says.silent_nodes, READY_PATIENCE, unready)
    if graph.stepped is not None:
        graph.stepped.let_time_run()
    if others := says.not_alone(own=1):
        raise ending.GraphError(others)
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
        (lambda: graph.goals.get_subscription_count() > 0, says.no_planner),
        (lambda: recorder.robot.get("knows_planner") == "yes", lambda: says.missing("robot/state", "reliable")),
    ):
        graph.wait(condition, watching.INPUT_PATIENCE, complaint)
    graph.is_ready = True
    graph.step()


PAUSE = 1.0  # rest at each end of a lap [s]
LATE = 1.0  # age at which a pose no longer shows the robot's present state [s]
CATCH_UP_PATIENCE = 5.0  # longest wait for poses that are not late, once those taken are [s]
CANCEL_PERIOD = 0.1  # period at which the planner is asked to end the goal: it may not be discovered yet [s]
CANCEL_PATIENCE = 0.3  # longest wait for the end of a goal that was canceled [s]


class Bringup(Graph):
    """One run, a context manager: entering starts the graph, leaving stops it.

    Most scripts need only `run()`; this class is for those that act during the run. Use it in a thread that lives as
    long as the graph: the nodes are killed when the thread that started them ends. Errors are those of Graph.
    """

    def __init__(self, options: Options, progress: Progress | None = None) -> None:
        """Checks everything and makes the run folder."""
        preparation = with_lidar_place(prepare(options))
        super().__init__(preparation, RunFolder(options.out, preparation.settings), progress or Progress())
        self._why = ""

    def __enter__(self) -> "Bringup":
        try:
            super().__enter__()
        except ending.StartError:
            self.folder.discard()
            raise
        except ending.BROKEN_OFF as error:
            self.progress.say(str(error))
            raise
        self.progress.say(self.folder.become_latest())
        return self

    def __exit__(self, *exception: object) -> None:
        if isinstance(exception[1], ending.BROKEN_OFF):  # at once: to stop the nodes takes some seconds
            self.progress.say(str(exception[1]))
        try:
            super().__exit__()
        except RecordError as lost:  # the last lines do not fit on the disk
            self.progress.say(str(lost))
            raise

    def drive_laps(self) -> None:
        """Drives to and fro between goal and start until an exception ends it: a signal or an error.

        A person may give goals in between. Where one cancels, or stops the robot, it stands until one gives a goal.
        """
        say = self.progress.say
        for target in cycle(self.preparation.ends):
            outcome = self.drive(target)
            self.come_to_rest()
            if outcome in ending.BY_A_PERSON:
                say(f"{outcome.replace('_', ' ')}: the robot stands until you give it a goal")
                self.wait(lambda: self.goal_is_active)
                self.wait(lambda: not self.goal_is_active)
            elif outcome != REACHED:
                say(self.reason(outcome))
            end = self.now() + PAUSE
            self.wait(lambda: self.now() > end)  # noqa: B023 (called in this lap)

    def drive(self, goal: np.ndarray | None = None) -> str:
        """Gives the goal (2,) [m], the prepared one by default, monitors the run, and returns its outcome.

        Reached, aborted or canceled are the planner's report; else it is timeout, stuck or emergency_stop.
        """
        target = self.preparation.goal if goal is None else goal
        recorder = self.recorder
        recorder.begin(self.preparation.robot.simulated)
        self.give_goal(target)
        monitor = RunMonitor(self.preparation.settings.trial, self.pose.stamp)
        while True:
            outcome = ending.outcome_of(recorder.goal, self.pose, recorder.maneuver, monitor)
            if outcome in ending.MONITORED and recorder.lateness > LATE:
                # poses arrived too late to show it
                self.wait(lambda: recorder.lateness <= LATE, CATCH_UP_PATIENCE, self.complaints.too_slow)
                continue
            if outcome is not None:
                break
            if recorder.emergency_stop:
                self.progress.say(self.reason(ending.EMERGENCY_STOP))
                return ending.EMERGENCY_STOP
            self._show_progress(target)
            self.step()
        # now: what ends the goal makes the controller stand for that reason
        self._why = f"{outcome}: {self._why_not_there(monitor.reason)}"
        return outcome

    def _show_progress(self, target: np.ndarray) -> None:
        pose, recorder = self.pose, self.recorder
        begin = recorder.time_zero
        # a pose of a while ago is not where the robot is now
        if begin is not None and pose.stamp >= begin and recorder.age <= LATE:
            distance = float(np.hypot(pose.x - target[0], pose.y - target[1]))
            pace = pace_words(recorder.real_time_factor)
            self.progress.show(pose.stamp - begin, distance, recorder.maneuver, recorder.n_impacts, pace)

    def come_to_rest(self) -> None:
        """Cancels a goal that has not ended, and waits until it has and the robot rests, at most REST_PATIENCE.

        A goal that has not ended within CANCEL_PATIENCE is not waited for: leave the graph then, which stops the robot.
        DrivesOn: it does not rest.
        """
        due = begun = self.now()
        while (now := self.now()) < begun + REST_PATIENCE:
            if self.goal_is_active:
                if now > begun + CANCEL_PATIENCE:
                    return
                if now >= due:
                    self.cancel_goal()
                    due = now + CANCEL_PERIOD
            elif self.listener.at_rest:
                return
            self.step()
        if (speed := self.listener.speed) > MOVES:
            raise ending.DrivesOn(
                f"the robot drives on at {speed:.2f} m/s, {now - begun:.0f} s after the end of its run"
            )

    @property
    def goal_is_active(self) -> bool:
        """True where the robot is on the way to a goal, whoever gave it."""
        goal = self.recorder.goal
        return goal is not None and goal.status not in ending.OUTCOMES

    def reason(self, outcome: str) -> str:
        """Returns why the goal was not reached, for the outcome of `drive`; the planner's report may come after it."""
        if outcome == ending.EMERGENCY_STOP:
            return self.recorder.emergency_stop
        if outcome == ABORTED:
            return self.recorder.status(PLANNER).message + self.complaints.frozen + self._hints
        return self._why + self._hints if outcome in ending.MONITORED else ""

    @property
    def _hints(self) -> str:
        settings = self.preparation.settings
        sight = sight_hint(self.recorder.blind, settings)
        noise = drive_noise_hint(settings) if self.preparation.robot.simulated else ""
        return (f"; {sight}" if sight else "") + noise

    def _why_not_there(self, monitored: str) -> str:
        """Why the robot is not at the goal: its own hold, else why the controller stands or holds, else the planner."""
        recorder, frozen = self.recorder, self.complaints.frozen
        if recorder.robot_held:
            return f"the robot is held: {recorder.robot_held}{frozen}"
        planner = f"{PLANNER}: {recorder.status(PLANNER).message}"
        return f"{monitored}{frozen}; {f'{COMMANDER}: {recorder.standing}' if recorder.standing else planner}"
