"""Each live parameter of planner and controller, set while it runs: what comes out afterwards is not the same."""

from collections.abc import Iterator
from copy import deepcopy
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from rclpy.parameter import Parameter

from collplan_core.command import Command
from collplan_core.goal import Goal
from collplan_core.loop.decisions import Cycle, Notice
from collplan_core.parameters import Settings, all_specs
from collplan_core.parameters.spec import ParameterError, Spec
from collplan_core.plan import Plan
from collplan_core.replay.comparison import Player
from collplan_core.replay.journal import CONTROLLER, PLANNER
from collplan_core.replay.reading import Call, events_of, rows_of
from collplan_core.replay.values import outcome_of
from collplan_core.worlds import load_world
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.lidar_node import LidarNode
from collplan_ros.nodes.mocap_node import MocapNode
from collplan_ros.nodes.planner_node import PlannerNode
from omnipuck_driver.driver_node import DriverNode
from omnipuck_sim.emulator.firmware_emulator import FirmwareEmulator
from omnipuck_sim.node.simulator_node import SimulatorNode
from omnipuck_sim.trial import run_trial

LIVE = [spec for spec in all_specs().values() if spec.live]
NODES = (MocapNode, LidarNode, PlannerNode, ControllerNode, SimulatorNode, DriverNode, FirmwareEmulator)
SHARES = (0.03, 0.0, 0.3, 1.0)
"""How far into its range a number is set."""
LARGE = {"planner.goal_timeout": 1.2, "planner.longest_detour": 0.02}
"""Values of parameters for which a share of the range is too large for a test [s], [m]."""
LONGEST = 5.0
"""Longest trial [s]."""


def accepted(node) -> list[Spec]:
    """The live parameters that a node takes."""
    return [spec for spec in LIVE if node.has_parameter(spec.key) and not node.describe_parameter(spec.key).read_only]


def others(spec: Spec) -> list:
    if spec.key in LARGE:
        return [LARGE[spec.key]]
    if isinstance(spec.default, bool):
        return [not spec.default]
    if spec.choices:
        return [choice for choice in spec.choices if choice != spec.default]
    values = [spec.low + share * (spec.high - spec.low) for share in SHARES]
    if isinstance(spec.default, int):
        values = [round(value) for value in values]
    return [value for value in values if value != spec.default]


def test_what_is_not_live_at_a_node_is_refused(ros, tmp_path):
    for kind in NODES:
        line = str(tmp_path / kind.__name__)
        node = ros.make(kind, {"emulator.link": line, "driver.port": line})
        taken = accepted(node)
        assert taken, kind
        for spec in LIVE:
            if node.has_parameter(spec.key) and spec not in taken:
                (result,) = node.set_parameters([Parameter(spec.key, value=others(spec)[0])])
                assert "read-only" in result.reason, spec.key
        ros.remove(node)


# ---- loops that are given the calls of a trial, and fork in the middle of it

MIXED = {"planner.strategy": "custom", "weights.position": 100.0, "weights.risk": 30.0, "weights.velocity": 4.0}
"""Every cost of the paper's planner has a say."""
COURSES = {"mixed": (LONGEST, MIXED), "bounce": (1.2, {"planner.strategy": "bounce"})}
"""Length [s] and settings of a trial."""
FAST = {"weights.position": 1.0, "weights.risk": 0.1, "weights.velocity": 40.0}
"""Places that the velocity cost alone chooses in."""
REBOUNDING = {"weights.position": 0.0, "weights.risk": 0.0, "weights.velocity": 40.0}
REBOUNDING |= {"planner.velocity_pruning": False, "planner.position_pruning": False, "local_map.predicted": "printed"}
REBOUNDING |= {"planner.collision_factor": False}
"""Velocities that lead into boundaries, as many as can be, of which the rebound alone says how good they are."""
CROSSING = {"weights.risk": 1e4, "weights.velocity": 0.0, "planner.gap_weight": 0.0}
CROSSING |= {"planner.position_pruning": False, "local_map.half_side": 1.0}
"""Places of which some are behind a boundary, and the risk of that counts most."""


def with_first(call: Call, change) -> Call:
    return replace(call, args=(change(call.args[0]), *call.args[1:]))


def leaps(now: float, call: Call) -> Call | None:
    aside = np.array([0.06, 0.0])
    leapt = call.name == "take_pose" and now >= 1.2
    return with_first(call, lambda pose: replace(pose, position=pose.position + aside)) if leapt else call


def poses_fail(now: float, call: Call) -> Call | None:
    return None if call.name == "take_pose" and 1.2 <= now < 1.3 else call


def scans_fail(now: float, call: Call) -> Call | None:
    return None if call.name == "take_scan" and 1.2 <= now < 1.6 else call


def stuck(now: float, call: Call, places: list = []) -> Call | None:  # noqa: B006 (it stays where it was first)
    if call.name != "take_pose" or now < 1.0:
        return call
    places.append(call.args[0].position)
    return with_first(call, lambda pose: replace(pose, position=places[0], velocity=np.zeros(2)))


def not_told(now: float, call: Call) -> Call | None:
    told = call.name == "take_plan"
    return with_first(call, lambda plan: replace(plan, valid_until=None)) if told else call


def through_walls(now: float, call: Call) -> Call | None:
    def longer(plan: Plan) -> Plan:
        start = plan.positions[0]
        return replace(plan, positions=start + 3.5 * (plan.positions - start))

    return with_first(call, longer) if call.name == "take_plan" else call


SCENES = {
    PLANNER: (
        ("random:3", "mixed", {}, None, 1.0, 2.0),
        ("corridor", "mixed", FAST, None, 1.0, 2.0),
        ("slalom", "mixed", REBOUNDING, None, 1.0, LONGEST),
        ("corridor", "mixed", CROSSING, None, 1.0, LONGEST),
        ("corridor", "mixed", {}, leaps, 1.0, 0.5),
        ("corridor", "mixed", {}, poses_fail, 1.0, 0.5),
        ("corridor", "mixed", {}, scans_fail, 1.0, 0.7),
        ("corridor", "mixed", {}, stuck, 0.9, LONGEST),
        ("corridor", "bounce", {}, None, 0.9, 0.5),
    ),
    CONTROLLER: (
        ("corridor", "mixed", {}, not_told, 0.8, 1.0),
        ("corridor", "mixed", {}, poses_fail, 1.0, 0.5),
        ("corridor", "mixed", {}, leaps, 1.0, 0.5),
        ("corridor", "mixed", {}, through_walls, 0.8, LONGEST),
    ),
}
"""World and course of a trial, other settings, other calls, when it forks and for how long [s]."""


@cache
def events(world: str, course: str, of: str) -> list:
    """The journal of a loop in a trial with a heading that is measured with noise."""
    longest, chosen = COURSES[course]
    values = {"trial.timeout": longest, "simulator.mocap_yaw_noise": 0.01, **chosen}
    with TemporaryDirectory() as folder:
        path = Path(folder) / "journal"
        run_trial(load_world(world), Settings().with_values(values), 1, journal=path)
        return list(events_of(rows_of(path.read_text().splitlines(), ""), of))


class ForkedLoop:
    """A loop that was given a course up to a moment, and what it puts out from then on without a change."""

    def __init__(self, of: str, world: str, course: str, under: dict, change, begin: float, lasts: float) -> None:
        beginning, *calls = events(world, course, of)
        now, before, self._calls = 0.0, [], []
        for given in calls:
            now = given.args[-1] if given.args and isinstance(given.args[-1], float) else now
            call = given if change is None else change(now, given)
            if call is not None and now < begin + lasts:
                (before if now < begin else self._calls).append(call)
        self._settings = beginning.settings.with_values(under)
        self._player = Player(of, replace(beginning, settings=self._settings))
        list(put_out(self._player, before))
        self._unchanged = list(put_out(deepcopy(self._player), self._calls))
        assert not self.changes({}), "equal loops differ"

    def changes(self, values: dict[str, object]) -> bool:
        """Whether the loop puts out something else with these settings."""
        player = deepcopy(self._player)
        try:
            player.loop.change_settings(self._settings.with_values(values))
        except ParameterError:
            return False
        return any(now != then for now, then in zip(put_out(player, self._calls), self._unchanged, strict=True))


def put_out(player: Player, calls: list[Call]) -> Iterator[object]:
    """What a loop puts out at each call, without its words, which may hold the parameter itself."""
    for call in calls:
        answer = player.play(call)
        verdict = getattr(getattr(player.loop, "motion", None), "verdict", None)
        shown = [without_words(each) for each in answer] if isinstance(answer, list) else without_words(answer)
        yield shown, verdict and (verdict.kind, repr(verdict.delay))


def without_words(answer) -> object:
    if isinstance(answer, Cycle):
        plan = answer.plan
        return outcome_of((plan.stamp, plan.times, plan.positions, plan.velocities, plan.contacts, plan.valid_until))
    if isinstance(answer, Notice):
        return answer.level
    if isinstance(answer, Command):
        return outcome_of((answer.velocity, answer.yaw_rate, answer.maneuver, bool(answer.reason)))
    return (answer.stamp, answer.status) if isinstance(answer, Goal) else bool(answer)


@pytest.mark.parametrize(("kind", "of"), [(PlannerNode, PLANNER), (ControllerNode, CONTROLLER)])
def test_what_is_set_live_changes_what_comes_out(ros, kind, of):
    forked = cache(lambda number: ForkedLoop(of, *SCENES[of][number]))
    numbers = range(len(SCENES[of]))
    specs = accepted(ros.make(kind))
    unheeded = [
        spec.key
        for spec in specs
        if not any(forked(number).changes({spec.key: value}) for number in numbers for value in others(spec))
    ]
    assert not unheeded, f"{kind.__name__} takes these and goes on as before: {', '.join(unheeded)}"
