"""Frames: only what has changed, and in the end every page knows the same, however slow it was."""

import json

from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_ros.view.frames import KEPT, LOSSY, Changes, Newest, Slot, as_json, joined

QUICK = settings(derandomize=True, deadline=None, max_examples=50)

NAMES = st.sampled_from(["robot", "scan", "plan", "goal", "costs", "trail", "periods"])
PARTS = st.recursive(st.integers() | st.text() | st.booleans() | st.none(), lambda inner: st.lists(inner, max_size=3))
PUTS = st.lists(st.lists(st.tuples(NAMES, PARTS), max_size=4), max_size=12)


def frames_of(puts):
    changes = Changes()
    for number, parts in enumerate(puts):
        for name, value in parts:
            changes.put(name, value)
        yield changes.take(float(number))


def lasting(parts):
    return {name: text for name, text in parts.items() if name not in (*LOSSY, "t")}


@QUICK
@given(PUTS)
def test_the_newest_of_all_parts_is_what_was_put_last(puts):
    newest = Newest()
    for frame in frames_of(puts):
        assert set(json.loads(joined(frame))) == set(frame)
        newest.add(frame)
    last = {name: as_json(value) for parts in puts for name, value in parts}
    whole = newest.whole()
    assert lasting({name: text for name, text in whole.items() if name != "history"}) == lasting(last)


@QUICK
@given(PUTS, st.lists(st.booleans(), min_size=12, max_size=12))
def test_a_slow_page_ends_up_with_the_same(puts, takes):
    slot, has, all_of = Slot(), {}, {}
    for frame, is_ready in zip(frames_of(puts), takes, strict=False):
        all_of.update(frame)
        slot.put(frame)
        if is_ready:
            has.update(slot.take())
    has.update(slot.take())
    assert has == all_of
    assert slot.take() == {}


def test_what_has_not_changed_is_not_sent_again_but_what_stands_for_one_frame_is():
    changes = Changes()
    changes.put("goal", {"at": [1, 2]})
    changes.put("periods", [50.0])
    assert set(changes.take(1.0)) == {"t", "goal", "periods"}
    changes.put("goal", {"at": [1, 2]})
    changes.put("periods", [50.0])
    assert set(changes.take(2.0)) == {"t", "periods"}
    changes.forget()
    changes.put("goal", {"at": [1, 2]})
    assert set(changes.take(3.0)) == {"t", "goal"}


def test_history_is_short_and_begins_anew_where_time_steps_back():
    newest = Newest()
    for number in range(KEPT + 5):
        newest.add({"t": as_json(float(number)), "robot": "[0]"})
    assert len(json.loads(newest.whole()["history"])) == KEPT
    newest.add({"t": "3.0", "robot": "[1]"})
    assert json.loads(newest.whole()["history"]) == [{"t": 3.0, "robot": [1]}]
    newest.forget()
    assert newest.whole() == {}
