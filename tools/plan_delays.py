"""Where the time goes from the stamp of a pose to the command of a plan that begins there, by the recording of a run.

DDS says when a message was sent, by the wall clock. When a node took it, and when it began to plan or to control, its
journal says by the steady clock. How far the one clock is ahead of the other follows from what cannot be: no message is
taken before it was sent, and no command is sent before its control period began.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from collplan_core.parameters import Mocap
from collplan_core.replay.journal import CONTROLLER, PLANNER
from collplan_core.replay.outcome import is_command, is_plan
from collplan_core.replay.reading import Beginning, Call, Event, Gap, events_of, rows_of
from collplan_core.replay.values import JournalError
from collplan_ros.messages.reading import seconds_from_stamp
from collplan_ros.recording.reading import messages, raw_messages
from collplan_ros.replay.recorded_journals import TOPICS as JOURNALS

STAGES = (
    "stamp of a pose, until the simulator sends it",
    "until mocap_node sends it",
    "until planner_node takes it",
    "until planner_node begins the plan",
    "until the plan is sent",
    "until controller_node takes it",
    "until the next control period begins",
    "until its command is sent",
    "until the command comes to bringup",
)
"""What each begins with, the one before ends with. The last one is beside the way: the robot takes the command too."""
MOST_DOUBT = 0.002
"""Where the clocks cannot be compared better than so, one was set in the run, or the machine stood [s]."""
LATE = 1.5
"""A control period longer than so many of its own was missed."""


class Tick(NamedTuple):
    """A control period.

    Attributes:
        local: when it began [s, steady clock].
        plan: stamp of the last plan that came since the period before [s]; None where none did.
        moves: whether its command follows a plan.
    """

    local: float
    plan: float | None
    moves: bool


class Command(NamedTuple):
    """When a command was sent, and when it came to the recorder [s, wall clock]."""

    sent: float
    came: float


@dataclass(frozen=True)
class Sent:
    """What was sent when [s, wall clock].

    Attributes:
        measured: poses of the motion capture, by their stamps [s].
        poses: those that mocap_node made of them, by their stamps [s].
        plans: plans, by their stamps [s].
        commands: commands, by their numbers, from 1.
        lost: reports of simulator_node: when, and simulated time given up in stalls until then [s].
    """

    measured: dict[float, float] = field(default_factory=dict)
    poses: dict[float, float] = field(default_factory=dict)
    plans: dict[float, float] = field(default_factory=dict)
    commands: dict[int, Command] = field(default_factory=dict)
    lost: list[tuple[float, float]] = field(default_factory=list)


@dataclass(frozen=True)
class Planned:
    """What planner_node did when [s, steady clock].

    Attributes:
        poses: poses taken, by their stamps [s].
        begun: when what led to a plan began, by the plan's stamp [s].
    """

    poses: Mapping[float, float]
    begun: Mapping[float, float]


@dataclass(frozen=True)
class Controlled:
    """What controller_node did when [s, steady clock].

    Attributes:
        poses: poses taken, by their stamps [s].
        plans: plans taken, by their stamps [s].
        ticks: all control periods, from the first one on.
        period: how long one should be [s].
    """

    poses: Mapping[float, float]
    plans: Mapping[float, float]
    ticks: Sequence[Tick]
    period: float


@dataclass(frozen=True, eq=False)
class RunDelays:
    """Where the time went in a run.

    Attributes:
        stages: (n, len(STAGES)) what each stage took of the n plans that a command followed [s]; none where the clocks
            could not be compared.
        doubt: how far off a stage may be that begins by one clock and ends by the other [s]; None as above.
        plans: number of plans made.
        missed: control periods on the way that were LATE.
        lost: simulated time given up in stalls on the way, as far as it was reported there [s].
    """

    stages: np.ndarray
    doubt: float | None
    plans: int
    missed: int
    lost: float


def read_run_delays(recording: Path) -> RunDelays:
    """Where the time went in a simulated run, by its run.mcap.

    Raises:
        RunError: the recording cannot be read.
        JournalError: there is no journal in it that is whole.
    """
    sent = Sent()
    lines: list[str] = []
    by_stamp = {Mocap().topic: sent.measured, "mocap/odom": sent.poses, "plan": sent.plans}
    topics = [*by_stamp, "cmd_vel", "/diagnostics", *JOURNALS]
    for raw, (topic, _, message) in zip(raw_messages(recording, topics), messages(recording, topics), strict=True):
        at = 1e-9 * raw.sent
        if topic in JOURNALS:
            lines.append(message.data)
        elif topic == "cmd_vel":
            sent.commands[raw.number] = Command(at, 1e-9 * raw.came)
        elif topic == "/diagnostics":
            sent.lost.extend((at, lost) for lost in _times_lost(message))
        else:
            by_stamp[topic][seconds_from_stamp(message.header.stamp)] = at
    rows = rows_of(lines, str(recording))
    return run_delays(sent, planned(events_of(rows, PLANNER)), controlled(events_of(rows, CONTROLLER)))


def planned(events: Iterable[Event]) -> Planned:
    """What planner_node did, by its journal.

    Raises:
        JournalError: it is not whole.
    """
    poses: dict[float, float] = {}
    begun: dict[float, float] = {}
    for call in _whole(events):
        if isinstance(call, Beginning):
            continue
        if call.name == "take_pose":
            state, local = call.given
            poses[state.stamp] = local
        for decision in call.came if is_plan(call.came) else ():
            if "plan" in decision:
                begun[decision["plan"]["stamp"]] = call.given[-1]
    return Planned(poses, begun)


def controlled(events: Iterable[Event]) -> Controlled:
    """What controller_node did, by its journal.

    Raises:
        JournalError: it is not whole.
    """
    poses: dict[float, float] = {}
    plans: dict[float, float] = {}
    ticks: list[Tick] = []
    period = math.nan
    newest: float | None = None
    for call in _whole(events):
        if isinstance(call, Beginning):
            period = 1.0 / call.settings.controller.rate
        elif call.name == "take_pose":
            state, local = call.given
            poses[state.stamp] = local
        elif call.name == "take_plan" and call.came is None:  # else it is why the plan is refused
            plan, local = call.given
            newest, plans[plan.stamp] = plan.stamp, local
        elif call.name == "tick" and is_command(call.came):  # one that failed sends none
            ticks.append(Tick(call.given[0], newest, not call.came["command"]["reason"]))
            newest = None
    return Controlled(poses, plans, ticks, period)


def run_delays(sent: Sent, planner: Planned, controller: Controlled) -> RunDelays:
    """Where the time went, from what was sent and what both nodes did."""
    ahead, doubt = _ahead(sent, planner, controller)
    is_known = doubt <= MOST_DOUBT
    stages = _stages(sent, planner, controller, ahead) if is_known else []
    late = (after.local - before.local for before, after in pairwise(controller.ticks) if after.moves)
    return RunDelays(
        stages=np.array(stages).reshape(-1, len(STAGES)),
        doubt=doubt if is_known else None,
        plans=len(planner.begun),
        missed=sum(passed > LATE * controller.period for passed in late),
        lost=_lost(sent, controller),
    )


def delay_table(by_strategy: Mapping[str, np.ndarray]) -> str:
    """A line a stage, and one up to the command, of the plans of each strategy; means add up, percentiles do not.

    Args:
        by_strategy: (n, len(STAGES)) what each stage took of n plans [ms], by the strategy's name.
    """
    to_command = len(STAGES) - 1
    columns = [(name, slice(k, k + 1)) for k, name in enumerate(STAGES)]
    columns.insert(to_command, ("**in all, from the stamp to the command**", slice(0, to_command)))
    heads = [f"{strategy}: mean [ms] | median | p99" for strategy in by_strategy]
    lines = [f"| | {' | '.join(heads)} |", "|---" * (1 + 3 * len(heads)) + "|"]
    for name, stages in columns:
        cells = [_figures(delays[:, stages].sum(axis=1)) for delays in by_strategy.values()]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _figures(delays: np.ndarray) -> str:
    if not len(delays):
        return " | | "
    return f"{delays.mean():.1f} | {np.median(delays):.1f} | {np.percentile(delays, 99):.1f}"


def _whole(events: Iterable[Event]) -> Iterator[Beginning | Call]:
    """The events of a journal from its beginning on: ticks and commands are told to belong together by counting."""
    begun = False
    for event in events:
        if isinstance(event, Gap):
            raise JournalError(str(event))
        begun = begun or isinstance(event, Beginning)
        yield event
    if not begun:
        raise JournalError("no journal of planner or controller")


def _ahead(sent: Sent, planner: Planned, controller: Controlled) -> tuple[float, float]:
    """How far the wall clock is ahead of the steady one, and how far off that may be [s]; NaN where nothing tells."""
    taken = (*planner.poses.items(), *controller.poses.items())
    least = max((sent.poses[stamp] - local for stamp, local in taken if stamp in sent.poses), default=math.nan)
    begun = [(sent.commands[n].sent, tick.local) for n, tick in _numbered(controller) if n in sent.commands]
    most = min((at - local for at, local in begun), default=math.nan)
    return 0.5 * (least + most), 0.5 * abs(most - least)


def _numbered(controller: Controlled) -> Iterator[tuple[int, Tick]]:
    """Control periods with the numbers of their commands: each sends one, the first the first."""
    return enumerate(controller.ticks, start=1)


def _stages(sent: Sent, planner: Planned, controller: Controlled, ahead: float) -> list[np.ndarray]:
    """(len(STAGES),) what each stage took, of each plan that a command follows and of which everything was recorded."""
    found = []
    everything = (sent.measured, sent.poses, planner.poses, planner.begun, sent.plans, controller.plans)
    for number, tick in _numbered(controller):
        stamp = tick.plan
        if stamp is None or not tick.moves or number not in sent.commands:
            continue
        if any(stamp not in each for each in everything):
            continue
        times = (
            stamp,
            sent.measured[stamp],
            sent.poses[stamp],
            planner.poses[stamp] + ahead,
            planner.begun[stamp] + ahead,
            sent.plans[stamp],
            controller.plans[stamp] + ahead,
            tick.local + ahead,
            *sent.commands[number],
        )
        found.append(np.diff(times))
    return found


def _lost(sent: Sent, controller: Controlled) -> float:
    """Time for which the simulator did not run, from the first command that moves the robot to the last one [s]."""
    moving = [sent.commands[n].sent for n, tick in _numbered(controller) if tick.moves and n in sent.commands]
    if not moving:
        return 0.0
    before, until = ([lost for at, lost in sent.lost if at <= end] for end in (moving[0], moving[-1]))
    return until[-1] - before[-1] if before else 0.0


def _times_lost(diagnostics: Any) -> Iterator[float]:
    """Time for which the simulator did not run [s], where a message of /diagnostics tells it."""
    for status in diagnostics.status:
        yield from (float(item.value) for item in status.values if item.key == "time_stalled")
