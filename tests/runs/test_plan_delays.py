"""Where the time of a plan goes, found from two clocks that nobody compares: tools/plan_delays.py."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import plan_delays
from collplan_core.parameters import Settings
from collplan_core.replay.journal import CONTROLLER, FORMAT, PLANNER
from collplan_core.replay.reading import Beginning, Call, Gap, events_of, rows_of
from collplan_core.replay.values import PLAN, JournalError, Reference, encode
from collplan_core.state import State
from collplan_core.worlds import load_world
from collplan_ros.recording.reading import Message
from omnipuck_sim.trial import CONTROLLER_PHASE, PLANNER_PHASE, run_trial
from plan_delays import (
    STAGES,
    Command,
    Controlled,
    Planned,
    Sent,
    Tick,
    controlled,
    delay_table,
    planned,
    read_run_delays,
    run_delays,
)

BEGINNING = Beginning(Settings(), None, {})
BY_ONE_CLOCK = [0, 1, 3, 6, 8]
"""Stages that begin and end by the same clock."""
short, longer = st.floats(1e-4, 1e-3), st.floats(0.0, 0.02)
stages = st.tuples(longer, longer, short, longer, longer, short, longer, short, short)


def command(reason):
    return {"command": {"reason": reason}}


def made(plans, ahead):
    """What is told of plans whose poses are a second apart, with these stages [s]."""
    sent, poses, begun, taken, ticks = Sent(), {}, {}, {}, []
    for k, each in enumerate(plans):
        stamp = 100.0 + k
        at = np.cumsum((stamp, *each)).tolist()
        sent.measured[stamp], sent.poses[stamp], sent.plans[stamp] = at[1], at[2], at[5]
        poses[stamp], begun[stamp], taken[stamp] = at[3] - ahead, at[4] - ahead, at[6] - ahead
        ticks.append(Tick(at[7] - ahead, stamp, True))
        sent.commands[k + 1] = Command(at[8], at[9])
    return sent, Planned(poses, begun), Controlled({}, taken, ticks, 1.0)


@given(st.lists(stages, min_size=1, max_size=8), st.floats(-1e4, 1e4))
def test_every_stage_is_found_as_well_as_is_said(plans, ahead):
    found = run_delays(*made(plans, ahead))
    assert found.doubt is not None
    errors = np.abs(found.stages - np.array(plans))
    assert errors.max() <= found.doubt + 1e-6
    assert errors[:, BY_ONE_CLOCK].max() <= 1e-6
    assert found.stages.sum(axis=1) == pytest.approx(np.sum(plans, axis=1), abs=1e-6)
    assert (found.plans, found.missed, found.lost) == (len(plans), 0, 0.0)


def test_where_a_clock_was_set_nothing_is_told_of_stages():
    sent, planner, controller = made([(0.001,) * len(STAGES)] * 3, 50.0)
    sent.commands[2] = Command(sent.commands[2].sent - 0.5, sent.commands[2].came - 0.5)
    found = run_delays(sent, planner, controller)
    assert (found.stages.shape, found.doubt, found.plans) == ((0, len(STAGES)), None, 3)


def test_a_plan_that_is_not_all_there_is_left_out():
    sent, planner, controller = made([(0.001,) * len(STAGES)] * 3, 50.0)
    del sent.plans[101.0]
    assert len(run_delays(sent, planner, controller).stages) == 2
    del sent.commands[1]
    assert len(run_delays(sent, planner, controller).stages) == 1


def test_a_command_follows_the_newest_plan_that_was_not_refused():
    plans = [
        Call("take_plan", (Reference(PLAN, 1.0, ""), 5.0)),
        Call("take_plan", (Reference(PLAN, 1.05, ""), 5.01)),
        Call("take_plan", (Reference(PLAN, 9.0, ""), 5.015), came="too new"),
    ]
    ticks = [Call("tick", (5.02,), came=command("")), Call("tick", (5.07,), came=command("no active goal"))]
    found = controlled([BEGINNING, *plans, *ticks])
    assert found.ticks == [Tick(5.02, 1.05, True), Tick(5.07, None, False)]
    assert found.plans == {1.0: 5.0, 1.05: 5.01}
    assert found.period == pytest.approx(1.0 / Settings().controller.rate)


@pytest.mark.parametrize("read", [planned, controlled])
@pytest.mark.parametrize("events", [[BEGINNING, Gap(3, 1)], []])
def test_a_journal_that_is_not_whole_is_refused(read, events):
    with pytest.raises(JournalError):
        read(events)


@pytest.mark.parametrize(("moves", "missed"), [(True, 1), (False, 0)])
def test_periods_missed_on_the_way_count(moves, missed):
    ticks = [Tick(local, None, moves) for local in (0.0, 0.05, 0.15, 0.2)]
    assert run_delays(Sent(), Planned({}, {}), Controlled({}, {}, ticks, 0.05)).missed == missed


def test_time_lost_before_the_way_does_not_count():
    ticks = [Tick(0.0, None, False), Tick(0.05, None, True), Tick(0.1, None, True), Tick(0.15, None, False)]
    commands = {k: Command(9.95 + 0.05 * k, 9.95 + 0.05 * k) for k in (1, 2, 3, 4)}
    lost = [(9.0, 0.0), (10.02, 0.5), (10.08, 0.75), (10.2, 2.0)]
    found = run_delays(Sent(commands=commands, lost=lost), Planned({}, {}), Controlled({}, {}, ticks, 0.05))
    assert found.lost == 0.25


def test_in_a_trial_a_command_follows_each_plan_as_late_as_the_phases_say(tmp_path):
    path = tmp_path / "trial.jsonl"
    settings = Settings().with_values({"planner.strategy": "avoid", "trial.timeout": 1.0})
    run_trial(load_world("corridor"), settings, 1, journal=path)
    rows = rows_of(path.read_text().splitlines(), str(path))
    planner, controller = planned(events_of(rows, PLANNER)), controlled(events_of(rows, CONTROLLER))
    followed = [tick for tick in controller.ticks if tick.moves and tick.plan is not None]
    assert len(followed) > 10
    for tick in followed:
        assert planner.poses[tick.plan] == pytest.approx(planner.begun[tick.plan])
        waited = tick.local - controller.plans[tick.plan]
        assert waited == pytest.approx(CONTROLLER_PHASE - PLANNER_PHASE)


def test_a_recording_is_read(monkeypatch, tmp_path):
    def stamped(stamp):
        return SimpleNamespace(header=SimpleNamespace(stamp=SimpleNamespace(sec=stamp, nanosec=0)))

    def journal(of, number, **line):
        return f"{of}/journal", 100.0, 0, SimpleNamespace(data=json.dumps({"number": number, "of": of, **line}))

    begins = {"format": FORMAT, "made_with": {}, "settings": encode(Settings()), "known_map": None}
    state = encode(State(100.0, np.zeros(2), np.zeros(2), 0.0))
    cycle = {"call": "cycle", "given": [50.01], "came": [{"plan": {"stamp": 100.0}}]}
    take_plan = {"call": "take_plan", "given": [encode(Reference(PLAN, 100.0, "0a")), 50.026]}
    tick = {"call": "tick", "given": [50.04], "came": command("")}
    lost = SimpleNamespace(values=[SimpleNamespace(key="time_lost_in_stalls", value="0.25")])
    recorded = [
        journal(PLANNER, 0, **begins),
        journal(CONTROLLER, 0, **begins),
        ("/diagnostics", 100.0, 0, SimpleNamespace(status=[lost])),
        ("mocap/pose", 100.001, 7, stamped(100)),
        ("mocap/odom", 100.0025, 7, stamped(100)),
        ("plan", 100.025, 1, stamped(100)),
        ("cmd_vel", 100.0405, 1, None),
        journal(PLANNER, 1, calls=[{"call": "take_pose", "given": [state, 50.003]}, cycle]),
        journal(CONTROLLER, 1, calls=[take_plan, tick]),
    ]
    ns = [(topic, round(1e9 * sent), number, message) for topic, sent, number, message in recorded]
    raw = [Message(topic, "", b"", sent + 1_000_000, sent, number) for topic, sent, number, _ in ns]
    whole = [(topic, sent + 1_000_000, message) for topic, sent, _, message in ns]
    monkeypatch.setattr(plan_delays, "raw_messages", lambda path, topics: (m for m in raw if m.topic in topics))
    monkeypatch.setattr(plan_delays, "messages", lambda path, topics: (m for m in whole if m[0] in topics))
    found = read_run_delays(tmp_path / "run.mcap")
    assert 1e3 * found.stages == pytest.approx(np.array([[1.0, 1.5, 0.5, 7.0, 15.0, 1.0, 14.0, 0.5, 1.0]]), abs=1e-3)
    assert found.doubt == pytest.approx(0.0005, abs=1e-6)
    assert (found.plans, found.missed, found.lost) == (1, 0, 0.0)


def test_the_table_has_means_that_add_up():
    each = np.array([np.arange(1.0, 10.0), np.arange(3.0, 12.0)])
    lines = delay_table({"bounce": each, "avoid": each[:0]}).splitlines()
    assert [line.count("|") for line in lines] == [8] * len(lines)
    cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines[2:]]
    assert [row[0] for row in cells if row[0] in STAGES] == list(STAGES)
    means = [float(row[1]) for row in cells]
    in_all = means.pop(len(STAGES) - 1)
    assert in_all == pytest.approx(sum(means[:-1]))
    assert {tuple(row[4:]) for row in cells} == {("", "", "")}
