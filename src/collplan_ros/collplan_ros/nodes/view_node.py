"""The live page's node: sends the graph's messages to open browsers, and their requests to the graph.

It decides nothing, and takes no part in moving the robot: any graph runs the same without it. While no page is open,
and has not been for a while, it subscribes to new goals alone, which are not repeated.
"""

import queue
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from itertools import count
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription
from std_srvs.srv import Trigger

from collplan_core.parameters import Frames, ScanInput, Settings, View
from collplan_core.scan import Scan
from collplan_core.strategies import NAMES
from collplan_core.worlds import World, WorldError, load_world
from collplan_ros.messages.conversions import goal_to_message, stamp_from_seconds
from collplan_ros.messages.qos import EVENT
from collplan_ros.messages.raw_reading import BYTES_TOPICS
from collplan_ros.node_kit.clock import seconds, steady_clock
from collplan_ros.node_kit.diagnostics import OK, Diagnostics, Health
from collplan_ros.node_kit.inputs import Info, with_info
from collplan_ros.node_kit.node_parameters import declare, read_settings
from collplan_ros.node_kit.run_node import run_node
from collplan_ros.node_kit.service_calls import ServiceCalls
from collplan_ros.run.topics import RecordedTopic, recorded_topics
from collplan_ros.view import scene
from collplan_ros.view.drawn_graph import DrawnGraph, Stamps
from collplan_ros.view.frames import Changes
from collplan_ros.view.requests import CANCEL, CHOOSE, CLEAR_STOP, GOAL, RESUME, STOP, PageCommand
from collplan_ros.view.server import PageServer, Reply

GOALS, STRATEGY = "goal_pose", "planner.strategy"
SERVICES = (STOP, CANCEL, RESUME, CLEAR_STOP)
"""Actions that are services of the same name."""
MOST_WAITING = 100
"""Commands that may wait; a stop always may."""
SCALES = ("robot.max_speed", "planner.goal_tolerance", "remembered.spacing")
PACE = ("simulator.speed_factor", "limits.command_age")
GROUPS = (View, ScanInput, Frames, "controller.stamped_cmd_vel", *SCALES, *PACE)
LINGER = 10.0
"""Time after the last page was closed until the graph is no longer listened to [s]: it may only be loaded anew."""
RATE = 20.0
"""Frames sent to a page per second [Hz]."""
MOST_PAGES = 20
"""Pages that may be open at once."""
IDLE_PERIOD = 0.25
"""Time between two checks whether a page is open [s]."""
WARN_PERIOD = 5.0
"""Shortest time between two log lines about refused requests [s]."""
ABOUT_EVERY = 10
"""One in so many frames is checked for changes of parts that seldom change."""
WORLDS = ("lidar.world", "simulator.world")
"""Parameters that name the world: the one that scans are cast in comes first."""


class ViewActions:
    """Takes commands from any thread and does them in the node's own."""

    def __init__(self, node: Node, calls: ServiceCalls, graph: Callable[[], DrawnGraph], frame: str) -> None:
        """Publishes and calls through `node`, to nodes that the present `graph` hears; goals are in `frame`."""
        self._node = node
        self._calls = calls
        self._graph = graph
        self._frame = frame
        self._goals = node.create_publisher(PoseStamped, "goal_pose", EVENT)
        for name in SERVICES:
            calls.keep(Trigger, name)
        self._order = count()
        self._inbox: queue.PriorityQueue[tuple[bool, int, PageCommand, Reply]] = queue.PriorityQueue()

    def take(self, command: PageCommand, reply: Reply) -> None:
        """Queues a command for the node; may be called from any thread."""
        if command.action != STOP and self._inbox.qsize() >= MOST_WAITING:
            reply(False, "too many commands are waiting")
            return
        self._inbox.put((command.action != STOP, next(self._order), command, reply))
        if self._node.executor is not None:
            self._node.executor.create_task(self.do_all)

    def do_all(self) -> None:
        """Executes the queued commands, stops first."""
        while True:
            try:
                *_, command, reply = self._inbox.get_nowait()
            except queue.Empty:
                return
            self._node.get_logger().info(f"page: {command.words}")
            self._do(command, reply)

    def _do(self, command: PageCommand, reply: Reply) -> None:
        if command.action in SERVICES:

            def answered(response: Trigger.Response | None, trouble: str) -> None:
                reply(bool(response and response.success), trouble if response is None else str(response.message))

            self._calls.now(command.action, Trigger.Request(), answered)
        elif command.action == GOAL:
            self._give_goal(command, reply)
        elif command.action == CHOOSE:
            self._choose(command.strategy, reply)

    def _choose(self, strategy: str, reply: Reply) -> None:
        """Sets the strategy of the planner among the nodes that are heard, and replies with its answer."""
        known, heard = self._graph().parameters, self._graph().heard
        planners = [node for node, values in known.items() if STRATEGY in values and node in heard]
        if not planners:
            reply(False, f"no node with {STRATEGY} was found")
            return

        def done(response: SetParameters.Response | None, trouble: str) -> None:
            if response is None:
                reply(False, trouble)
                return
            result = response.results[0]
            reply(bool(result.successful), str(result.reason) or f"{STRATEGY} is {strategy}")

        value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=strategy)
        request = SetParameters.Request(parameters=[Parameter(name=STRATEGY, value=value)])
        self._calls.soon(SetParameters, f"{planners[-1]}/set_parameters", request, done)

    def _give_goal(self, command: PageCommand, reply: Reply) -> None:
        # this node receives goals too
        if self._goals.get_subscription_count() < 2:
            reply(False, f"no node subscribes to {self._goals.topic_name}")
            return
        message = goal_to_message(np.array(command.at), self._frame)
        message.header.stamp = stamp_from_seconds(1e-9 * self._node.get_clock().now().nanoseconds)
        self._goals.publish(message)
        reply(True, f"{command.words} given")


class ViewNode(Node):
    """Serves the page on this machine; subscribes to shown topics, gives goals, calls services, sets the strategy."""

    def __init__(self, **kwargs: Any) -> None:
        """Keyword arguments go to `rclpy.node.Node`; PortTaken: view.port cannot be listened on."""
        super().__init__("view_node", **kwargs)
        declare(self, *GROUPS, live=())
        self._settings: Settings = read_settings(self, *GROUPS)
        # steady even where the node follows /clock: people look in their own time
        self._steady = steady_clock()
        self._changes = Changes()
        self._calls = ServiceCalls(self)
        self._graph = self._new_graph()
        self._topics = [each for each in recorded_topics(self._settings).values() if each.shown]
        self._goals = next(self._subscribed(each) for each in self._topics if each.name == GOALS)
        self._shown: list[Subscription] = []
        self._n_unread, self._newest_unread = 0, ""
        self._actions = ViewActions(self, self._calls, lambda: self._graph, self._settings.frames.map)
        self._loader = ThreadPoolExecutor(max_workers=1, thread_name_prefix="world")
        self._world_name: str | None = None
        self._world: Future[World] | None = None
        self._watched = False
        self._frames = 0
        Scan(0.0, 0.0, 1.0, 0.0, 1.0, np.ones(2))  # loads what was compiled, so that the first scan is not late
        self._server = PageServer(self._settings.view.port, MOST_PAGES, self._actions.take, self._warn)
        self._timer = self.create_timer(IDLE_PERIOD, self._tick, clock=self._steady)
        self._diagnostics = Diagnostics(self, self._health)
        self.get_logger().info(f"open {self.address} in a browser on this machine")

    @property
    def address(self) -> str:
        """Address of the page."""
        return self._server.address

    def _new_graph(self) -> DrawnGraph:
        stamps = Stamps(partial(seconds, self._steady))
        return DrawnGraph(self._settings, self._changes, self.get_namespace(), stamps)

    def _warn(self, words: str) -> None:
        # refused requests must not fill a disk
        self.get_logger().warning(words, throttle_duration_sec=WARN_PERIOD)

    def _tick(self) -> None:
        watched = self._server.unwatched_for() < LINGER
        if watched != self._watched:
            self._watch(watched)
        self._calls.step()
        if watched:
            time = self._graph.put_frame()
            if self._frames % ABOUT_EVERY == 0:
                self._put_about()
            self._server.publish(self._changes.take(time))
            self._frames += 1

    def _watch(self, watched: bool) -> None:
        """Begins anew: subscribes to everything that is shown, or ends that."""
        self._watched = watched
        self._timer.timer_period_ns = round(1e9 / RATE) if watched else round(1e9 * IDLE_PERIOD)
        for subscription in self._shown:
            self.destroy_subscription(subscription)
        self._shown = []
        goal, self._graph = self._graph.goal, self._new_graph()
        self._graph.goal = goal
        if watched:
            self._shown = [self._subscribed(each) for each in self._topics if each.name != GOALS]
            self._graph.put_goal()
        else:
            self._changes.take(0.0)
            self._changes.forget()
            self._server.forget()

    def _subscribed(self, topic: RecordedTopic) -> Subscription:
        def taking(data: bytes, info: Info) -> None:
            if subscription is not self._goals and subscription not in self._shown:
                return  # it came while all ended
            # a message of another program may be wrong in any way, and must not end a viewer
            try:
                message = data if topic.name in BYTES_TOPICS else deserialize_message(data, topic.kind)
                self._graph.takers[topic.name](message, 1e-9 * info["source_timestamp"])
            except Exception as error:
                self._n_unread += 1
                self._newest_unread = f"{subscription.topic}: {' '.join(str(error).split())}"

        # as bytes: an executor that cannot read a message raises
        subscription = self.create_subscription(topic.kind, topic.name, with_info(taking), topic.shown, raw=True)
        return subscription

    def _put_about(self) -> None:
        known, heard = self._graph.parameters, self._graph.heard
        # reports of a node that has gone no longer hold
        there = {name: each for name, each in known.items() if name in heard}
        world, trouble = self._found_world(there)
        kind = scene.which_robot(self._graph.robot, known, heard)
        about = scene.about(kind, self.get_namespace(), self._world_name or "", self._settings)
        radius = first_of(there, "robot.radius")
        if isinstance(radius, int | float) and abs(radius) <= scene.LARGEST:
            (about["radius"],) = scene.milli([radius])
        self._changes.put("about", about | {"trouble": trouble})
        self._changes.put("world", world)
        strategy = first_of(there, STRATEGY)
        # one that was registered in the planner's process alone is no name here
        choices = [*NAMES, *({strategy} - {*NAMES})]
        self._changes.put("strategy", None if strategy is None else {"value": strategy, "choices": choices})
        self._graph.put_machine()

    def _found_world(self, known: Mapping[str, scene.Values]) -> tuple[scene.Part, str]:
        """Returns the world named by nodes with these parameters, or the reason why there is none."""
        name = next((str(found) for key in WORLDS if (found := first_of(known, key)) is not None), None)
        if name != self._world_name:
            self._world_name = name
            # a stop must not wait for it
            self._world = None if name is None else self._loader.submit(load_world, name)
        if self._world is None or not self._world.done():
            return None, ""
        try:
            return scene.world(self._world.result()), ""
        except (WorldError, OSError, ValueError) as error:
            return None, str(error)

    def _health(self) -> Health:
        pages = self._server.n_clients
        values = {"address": self.address, "pages": pages, "frames": self._frames, "refused": self._server.n_refused}
        values |= {"unread": self._n_unread, "newest_unread": self._newest_unread}
        return Health(OK, f"{self.address}, {pages} {'page' if pages == 1 else 'pages'} open", values)

    def destroy_node(self) -> None:
        """Closes the pages first."""
        self._server.close()
        self._loader.shutdown(wait=False, cancel_futures=True)
        super().destroy_node()


def first_of(values: Mapping[str, scene.Values], name: str) -> Any:
    """The value of a parameter in the first node that has it; None where none has."""
    return next((each[name] for each in values.values() if name in each), None)


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    return run_node(ViewNode, args)
