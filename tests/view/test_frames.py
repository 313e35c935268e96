"""Frames: only what has changed, and the newest of all for a page that comes late."""

import json

from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_ros.view.frames import KEPT, LOSSY, Changes, Newest, as_json, joined

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
