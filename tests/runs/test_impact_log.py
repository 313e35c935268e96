"""Impacts of a run: placed on the world, with velocities, foreseen and deliberate."""

from dataclasses import replace

import numpy as np
import pytest

from collplan_core.impact import POSES, SIMULATED
from collplan_core.plan import Contacts
from collplan_ros.run.record import record_of
from collplan_ros.run.run_log import RunLog
from made_runs import EPOCH, HIT, HIT_AT, SPEED, WALL, WINDOW, bouncing_run, detected_only


def test_an_impact_is_the_simulated_one_or_without_the_truth_the_measured_one():
    for log, source in ((bouncing_run(), SIMULATED), (detected_only(bouncing_run()), POSES)):
        record = record_of(log, WINDOW)
        (impact,) = record.impacts
        assert impact.source == source
        assert impact.point == pytest.approx([WALL, 0.1], abs=1e-9)
        assert (impact.time, record.speeds.tolist()) == (EPOCH + HIT_AT - 0.003, [SPEED])
        assert record.restitutions == pytest.approx([0.5], abs=0.05)
        assert record.verdicts.foreseen.tolist() == record.verdicts.deliberate.tolist() == [True]
    both = replace(bouncing_run(), impacts=[HIT, replace(HIT, source=POSES)])
    assert [impact.source for impact in record_of(both, WINDOW).impacts] == [SIMULATED]
    assert record_of(RunLog(impacts=log.impacts), WINDOW).impacts == ()


def test_a_graze_is_not_deliberate_nor_is_what_no_plan_foresaw():
    log = bouncing_run()
    log.impacts = [replace(HIT, velocity_before=np.array([0.15, 0.0]))]
    assert record_of(log, WINDOW).verdicts.deliberate.tolist() == [False]
    assert record_of(log, WINDOW).restitutions == []
    log = bouncing_run()
    log.plans = dict.fromkeys(log.plans, Contacts.none())
    record = record_of(log, WINDOW)
    assert record.verdicts.deliberate.tolist() == [False]
    assert np.isnan(record.verdicts.rebounds).all()


def test_plans_without_a_scan_of_their_stamp_and_many_a_second():
    log = bouncing_run()
    touch = log.plans[EPOCH]
    log.plans = {EPOCH + 0.01 * k + 0.003: touch for k in range(95)}
    assert record_of(log, WINDOW).verdicts.foreseen.tolist() == [True]
    # the last one before the hit no longer expects it
    log.plans[EPOCH + 0.98] = Contacts.none()
    assert record_of(log, WINDOW).verdicts.foreseen.tolist() == [False]
