"""The live page's node: sends the graph's messages to open browsers, and their requests to the graph.

It decides nothing, and takes no part in moving the robot: any graph runs the same without it. While no page is open,
and has not been for a while, it subscribes to new goals alone, which are not repeated.
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription

from collplan_core.parameters import Frames, ScanInput, Settings, View
from collplan_core.scan import Scan
from collplan_core.strategies import NAMES
from collplan_core.worlds import World, WorldError, load_world
from collplan_ros.messages.raw_reading import BYTES_TOPICS
from collplan_ros.node_kit.clock import seconds, steady_clock
from collplan_ros.node_kit.diagnostics import OK, Diagnostics, Health
from collplan_ros.node_kit.inputs import Info, with_info
from collplan_ros.node_kit.node_parameters import declare, read_settings
from collplan_ros.node_kit.run_node import run_node
from collplan_ros.node_kit.service_calls import ServiceCalls
from collplan_ros.nodes.view_actions import STRATEGY, ViewActions
from collplan_ros.run.topics import RecordedTopic, recorded_topics
from collplan_ros.view import scene
from collplan_ros.view.drawn_graph import DrawnGraph, Stamps
from collplan_ros.view.frames import Changes
from collplan_ros.view.server import PageServer

GOAL = "goal_pose"
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
        self._goals = next(self._subscribed(each) for each in self._topics if each.name == GOAL)
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
        return DrawnGraph(self._settings, self._changes, self.get_namespace(), Stamps(self._now))

    def _now(self) -> float:
        return seconds(self._steady)

    def _warn(self, words: str) -> None:
        # refused requests must not fill a disk
        self.get_logger().warning(words, throttle_duration_sec=WARN_PERIOD)

    def _tick(self) -> None:
        watched = self._server.unwatched_for() < LINGER
        if watched != self._watched:
            self._watched = watched
            if watched:
                self._open()
            else:
                self._close()
        self._calls.step()
        if not watched:
            return
        time = self._graph.put_frame()
        if self._frames % ABOUT_EVERY == 0:
            self._put_about()
        self._server.publish(self._changes.take(time))
        self._frames += 1

    def _open(self) -> None:
        self._timer.timer_period_ns = round(1e9 / RATE)
        self._begin_anew()
        self._shown = [self._subscribed(each) for each in self._topics if each.name != GOAL]
        self._graph.put_goal()

    def _close(self) -> None:
        self._timer.timer_period_ns = round(1e9 * IDLE_PERIOD)
        for subscription in self._shown:
            self.destroy_subscription(subscription)
        self._shown = []
        self._begin_anew()
        self._changes.take(0.0)
        self._changes.forget()
        self._server.forget()

    def _begin_anew(self) -> None:
        goal, self._graph = self._graph.goal, self._new_graph()
        self._graph.goal = goal

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
        radius = _milli(first_of(there, "robot.radius"), self._settings.robot.radius)
        self._changes.put("about", about | {"trouble": trouble, "radius": radius})
        self._changes.put("world", world)
        strategy = first_of(there, STRATEGY)
        # one that was registered in the planner's process alone is no name here
        choices = [*NAMES, *({strategy} - {*NAMES})]
        self._changes.put("strategy", None if strategy is None else {"value": strategy, "choices": choices})
        self._graph.put_machine()

    def _found_world(self, known: Mapping[str, scene.Values]) -> tuple[scene.Part, str]:
        """Returns the world named by nodes with these parameters, or the reason why there is none."""
        name = next((found for key in WORLDS if (found := first_of(known, key)) is not None), None)
        if name is None:
            self._world_name = None
            return None, ""
        if name != self._world_name:
            self._world_name = str(name)
            # a stop must not wait for it
            self._world = self._loader.submit(load_world, self._world_name)
        if self._world is None or not self._world.done():
            return None, ""
        try:
            return scene.world(self._world.result()), ""
        except (WorldError, OSError, ValueError) as error:
            return None, str(error)

    def _health(self) -> Health:
        values: dict[str, object] = {
            "address": self.address,
            "pages": self._server.n_clients,
            "frames": self._frames,
            "refused": self._server.n_refused,
            "unread": self._n_unread,
            "newest_unread": self._newest_unread,
        }
        pages = self._server.n_clients
        return Health(OK, f"{self.address}, {pages} {'page' if pages == 1 else 'pages'} open", values)

    def destroy_node(self) -> None:
        """Closes the pages first."""
        self._server.close()
        self._loader.shutdown(wait=False, cancel_futures=True)
        super().destroy_node()


def first_of(values: Mapping[str, scene.Values], name: str) -> Any:
    """The value of a parameter in the first node that has it; None where none has."""
    return next((each[name] for each in values.values() if name in each), None)


def _milli(value: object, otherwise: float) -> int:
    """Returns a length or speed as sent to a page; `otherwise` where it cannot be drawn."""
    number = float(value) if isinstance(value, (int, float)) else otherwise
    return scene.milli([number if abs(number) <= scene.LARGEST else otherwise])[0]


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    return run_node(ViewNode, args)
