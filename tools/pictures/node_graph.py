"""node_graph.svg: the nodes and the topics between them, as the running graph says."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from collplan_core.parameters import Settings
from collplan_core.planners import PAPER, ROLLOUTS
from drawing import BORDER, CHOICE, DPI, FAINT, OBSTACLE_EDGE, TEXT, WIDTH, new_figure, save
from running_graph import Topics, topics_by_node

SIZE = (17.7, 12.2)
"""Size of the drawing, in its own units."""


class Box(NamedTuple):
    """A rectangle by its middle, and half its width and height."""

    x: float
    y: float
    half_width: float
    half_height: float

    def nearest(self, x: float, y: float) -> tuple[float, float]:
        """The point of its border or inside of it that is nearest to (x, y)."""
        return (
            min(max(x, self.x - self.half_width), self.x + self.half_width),
            min(max(y, self.y - self.half_height), self.y + self.half_height),
        )


ROBOT = "the robot, one of"
BOXES = {
    ROBOT: Box(1.8, 6.3, 1.65, 3.9),
    "mocap_node": Box(7.3, 9.4, 1.15, 0.6),
    "lidar_node": Box(9.6, 6.4, 0.95, 0.45),
    "teleop_node": Box(7.0, 11.5, 1.1, 0.45),
    "planner_node": Box(15.7, 9.3, 1.9, 1.3),
    "controller_node": Box(15.7, 3.1, 1.9, 1.3),
    "view_node": Box(13.0, 11.5, 1.15, 0.45),
}
ALTERNATIVES = (("simulator_node",), ("driver_node", "firmware_emulator"))
"""What the robot is: simulated, or behind a serial line, where the real one takes the emulator's place."""
TOPICS = {
    "mocap/pose": (4.9, 9.4),
    "mocap/odom": (7.3, 6.4),
    "impact": (10.4, 9.3),
    "scan": (11.55, 6.4),
    "plan": (15.6, 5.75),
    "goal_status": (16.4, 7.35),
    "goal_pose": (15.7, 11.5),
    "joy": (4.6, 11.5),
    "hand/cmd_vel": (10.1, 11.5),
    "cmd_vel": (11.8, 3.1),
    "robot/resumed": (8.8, 2.1),
}
"""Where the topics between nodes stand, and those that come from outside."""
COMPANIONS = {
    "mocap/refused": "mocap/odom",
    "planner/foreseen_impacts": "plan",
    "planner/valid_until": "plan",
    "planner/heartbeat": "plan",
    "robot/state": "robot/resumed",
}
"""Topics that are drawn in the place of another one, which they go with."""
AT_BOX = {
    (ROBOT, "impact"): (3.45, 7.9),
    (ROBOT, "robot/resumed"): (3.45, 2.65),
    ("mocap/odom", "planner_node"): (13.8, 8.7),
    ("mocap/odom", "controller_node"): (13.8, 3.85),
    ("scan", "planner_node"): (13.8, 8.3),
    ("cmd_vel", "planner_node"): (14.2, 8.0),
    ("scan", "controller_node"): (13.8, 4.15),
    ("hand/cmd_vel", "planner_node"): (13.8, 9.9),
    ("hand/cmd_vel", "controller_node"): (13.8, 4.3),
    ("planner_node", "plan"): (14.8, 8.0),
    ("goal_status", "controller_node"): (17.5, 4.4),
    ("goal_status", ROBOT): (3.45, 7.35),
    ("robot/resumed", "controller_node"): (13.8, 2.2),
    ("robot/resumed", "planner_node"): (13.95, 8.0),
}
"""Where an arrow meets a box, if not where the box is nearest to the topic."""


PAPER_PLANS, TIME_TO_GOAL_PLANS = 1.0 / PAPER.map_period, 1.0 / ROLLOUTS.map_period
"""[Hz]"""


class Arrow(NamedTuple):
    """An arrow from a box to a topic, or from a topic to a box."""

    begin: str
    end: str
    always: bool
    """Whatever the robot is."""


class NoPosition(LookupError):
    """A node or a topic of the running graph that the picture has no place for; the message names it."""


def rates(settings: Settings) -> dict[str, list[str]]:
    """How often the topics come, a line each, where a parameter says so."""
    mocap = settings.simulator.mocap_rate
    return {
        "mocap/pose": [f"{mocap:g} Hz"],
        "mocap/odom": [f"{mocap:g} Hz"],
        "scan": [f"{settings.lidar.rate:g} Hz"],
        "plan": [f"{PAPER_PLANS:g} or {TIME_TO_GOAL_PLANS:g} Hz"],
        "cmd_vel": [f"{settings.controller.rate:g} Hz"],
    }


def box_of(node: str) -> str:
    """The box that a node is drawn in."""
    box = ROBOT if any(node in each for each in ALTERNATIVES) else node
    if box not in BOXES:
        raise NoPosition(f"node {node}: no position, expected one in node_graph.BOXES")
    return box


def place_of(topic: str) -> str:
    """The topic in whose place a topic is drawn: its own, or that of the one it goes with."""
    return COMPANIONS.get(topic, topic)


def connecting(graph: Mapping[str, Topics]) -> dict[str, str]:
    """Topics that a node listens to, with their types.

    Raises:
        NoPosition: one of them has no place in the picture.
    """
    found = {name: kind for topics in graph.values() for name, kind in topics.subscribed.items()}
    for name in found:
        if place_of(name) not in TOPICS:
            raise NoPosition(f"topic {name}: no position, expected one in node_graph.TOPICS")
    return found


def arrows(graph: Mapping[str, Topics]) -> list[Arrow]:
    """Every arrow of the picture, once a box."""
    topics = connecting(graph)
    ends: dict[tuple[str, str], set[str]] = {}
    for node, (published, subscribed) in graph.items():
        for topic in published.keys() & topics.keys():
            ends.setdefault((box_of(node), place_of(topic)), set()).add(node)
        for topic in subscribed:
            ends.setdefault((place_of(topic), box_of(node)), set()).add(node)
    return [Arrow(*pair, _always(pair, nodes)) for pair, nodes in sorted(ends.items())]


def _always(pair: tuple[str, str], nodes: set[str]) -> bool:
    return ROBOT not in pair or all(nodes & set(each) for each in ALTERNATIVES)


def draw(path: Path, dpi: int = DPI, graph: Mapping[str, Topics] | None = None) -> list[Arrow]:
    """Writes the picture of a graph, of the running one by default; the arrows drawn."""
    graph = topics_by_node() if graph is None else graph
    drawn, topics, often = arrows(graph), connecting(graph), rates(Settings())
    figure = new_figure(WIDTH * SIZE[1] / SIZE[0], layout="none")
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, SIZE[0]), ylim=(0.0, SIZE[1]), aspect="equal")
    axes.axis("off")
    pills = {
        name: _draw_topic(axes, name, [kind, *often.get(name, []), *_companions(name, topics)])
        for name, kind in topics.items()
        if name in TOPICS
    }
    for name, box in BOXES.items():
        _draw_box(axes, name, box, _unheard(graph, name, topics))
    for arrow in drawn:
        _draw_arrow(axes, arrow, {**BOXES, **pills})
    _draw_caption(axes)
    save(figure, path, dpi)
    return drawn


def _unheard(graph: Mapping[str, Topics], box: str, topics: Mapping[str, str]) -> list[str]:
    """What a box publishes and no node listens to."""
    return sorted(
        {name for node, each in graph.items() if box_of(node) == box for name in each.published} - set(topics)
    )


def _companions(name: str, topics: Mapping[str, str]) -> list[str]:
    """What is drawn in the place of a topic beside itself."""
    return sorted(topic for topic in topics if topic in COMPANIONS and place_of(topic) == name)


def _draw_topic(axes: Axes, name: str, lines: list[str]) -> Box:
    box = Box(*TOPICS[name], 0.068 * max(len(name) * 1.35, *map(len, lines)) + 0.15, 0.24 + 0.15 * len(lines))
    axes.add_patch(_rounded(box, 0.2, "#eaf3fb", BORDER, 0.9))
    first = box.y + 0.15 * len(lines)
    axes.text(box.x, first, name, fontsize=8.5, color=TEXT, ha="center", va="center", weight="bold", zorder=6)
    for k, line in enumerate(lines, start=1):
        axes.text(box.x, first - 0.3 * k, line, fontsize=7.0, color=FAINT, ha="center", va="center", zorder=6)
    return box


def _draw_box(axes: Axes, name: str, box: Box, unheard: list[str]) -> None:
    axes.add_patch(_rounded(box, 0.12, "#f4f5f7", TEXT, 1.3))
    lines = [(name, TEXT, 9.0, "bold")] if name != ROBOT else _robot_lines()
    lines += [("also publishes", FAINT, 7.0, "normal")] * bool(unheard)
    lines += [(topic, FAINT, 7.0, "normal") for topic in unheard]
    spacing = 0.33
    top = box.y + 0.5 * spacing * (len(lines) - 1)
    for k, (text, color, size, weight) in enumerate(lines):
        axes.text(
            box.x,
            top - spacing * k,
            text,
            fontsize=size,
            color=color,
            weight=weight,
            ha="center",
            va="center",
            zorder=6,
        )


def _robot_lines() -> list[tuple[str, str, float, str]]:
    (simulated,), (driver, emulator) = ALTERNATIVES
    return [
        (ROBOT, FAINT, 8.0, "normal"),
        ("", FAINT, 7.0, "normal"),
        (simulated, TEXT, 9.0, "bold"),
        ("or", FAINT, 8.0, "normal"),
        (driver, TEXT, 9.0, "bold"),
        ("↕ serial line", FAINT, 8.0, "normal"),
        ("Omnipuck or", TEXT, 8.0, "normal"),
        (emulator, TEXT, 9.0, "bold"),
        ("", FAINT, 7.0, "normal"),
    ]


def _rounded(box: Box, rounding: float, face: str, edge: str, width: float) -> FancyBboxPatch:
    corner = box.x - box.half_width + rounding, box.y - box.half_height + rounding
    return FancyBboxPatch(
        corner,
        2.0 * (box.half_width - rounding),
        2.0 * (box.half_height - rounding),
        boxstyle=f"round,pad={rounding},rounding_size={rounding}",
        facecolor=face,
        edgecolor=edge,
        linewidth=width,
        zorder=5,
    )


def _draw_arrow(axes: Axes, arrow: Arrow, places: Mapping[str, Box]) -> None:
    to_topic = arrow.end in TOPICS
    box, topic = (places[each] for each in ((arrow.begin, arrow.end) if to_topic else (arrow.end, arrow.begin)))
    at_box = AT_BOX.get((arrow.begin, arrow.end)) or box.nearest(topic.x, topic.y)
    at_topic = topic.nearest(*at_box)
    start, tip = (at_box, at_topic) if to_topic else (at_topic, at_box)
    axes.add_patch(
        FancyArrowPatch(
            start,
            tip,
            arrowstyle="-|>",
            mutation_scale=9.0,
            shrinkA=0.0,
            shrinkB=0.0,
            linewidth=1.1,
            zorder=4,
            color=TEXT if arrow.always else CHOICE,
            linestyle="-" if arrow.always else (0, (4, 2)),
        )
    )


def _draw_caption(axes: Axes) -> None:
    paper, time_to_goal = f"{PAPER_PLANS:g} Hz", f"{TIME_TO_GOAL_PLANS:g} Hz"
    lines = (
        "Read from the running graph. Red: driver_node alone, where the firmware says that the ring senses impacts.",
        "mocap/pose of a real robot comes from the motion capture, joy from joy_node. "
        f"plan: {paper} with the paper's strategies, {time_to_goal} with the time-to-goal ones.",
        "view_node hears nearly all of it while a page is open. "
        "Left out: services, and what every node has, such as /diagnostics.",
    )
    for k, line in enumerate(lines):
        axes.text(0.15, 1.0 - 0.36 * k, line, fontsize=7.0, color=FAINT, va="center")
    axes.axhline(1.35, color=OBSTACLE_EDGE, linewidth=0.6, xmin=0.01, xmax=0.99)
