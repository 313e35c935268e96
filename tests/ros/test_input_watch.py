"""What there is to say about one input: once for each change, and never more."""

import pytest

from collplan_ros.node_kit.inputs import COMES, EVENT, STATE, STREAM, InputWatch

NOBODY, HEARD = [], [""]
ABSENT, SILENT = "no scan: 0 publishers", "no scan: 1 publisher, nothing received"


@pytest.mark.parametrize(
    ("need", "seconds"),
    [
        # messages taken, refused, who publishes, what is said: missing once a reason, one missed second is nothing
        (STREAM, [(0, 0, NOBODY, ""), (0, 0, NOBODY, ABSENT), (0, 0, NOBODY, ""), (0, 0, HEARD, SILENT)]),
        (
            STREAM,
            [(3, 0, HEARD, COMES), (0, 0, HEARD, ""), (3, 0, HEARD, ""), (0, 0, HEARD, ""), (0, 0, HEARD, SILENT)],
        ),
        # refused is not missing, and once for each reason; so is that nothing else comes any more
        (STREAM, [(0, 20, HEARD, "refused"), (0, 20, HEARD, ""), (1, 1, HEARD, COMES), (1, 1, HEARD, "")]),
        (STREAM, [(1, 1, HEARD, COMES), (0, 1, HEARD, "refused")]),
        # a state is there while somebody publishes it
        (STATE, [(1, 0, HEARD, COMES), (0, 0, HEARD, ""), (0, 0, NOBODY, ""), (0, 0, NOBODY, ABSENT)]),
        (EVENT, [(0, 0, NOBODY, ""), (0, 0, NOBODY, ""), (1, 0, HEARD, ""), (0, 1, HEARD, "refused")]),
    ],
)
def test_what_is_said(need, seconds):
    publishers, numbers = NOBODY, iter(range(1000))
    watch = InputWatch("scan", need, lambda: publishers)
    for taken, refused, publishers, said in seconds:  # noqa: B007 (the watch asks for it)
        watch.n_taken += taken
        for _ in range(refused):
            watch.refused(f"pose {next(numbers)}")  # other numbers are no other reason
        lines = watch.check()
        assert bool(said) == bool(lines), (seconds, lines)
        assert said in str(lines)


ODD, EVEN, RARE = "but of type Odd", "but of type Even", "but of type Rare"


@pytest.mark.parametrize(
    ("need", "seconds"),
    [
        # messages taken, publishers, what is said: once, whether it is missing, comes from another one or may be quiet
        (STREAM, [(0, [ODD], ""), (0, [ODD], f"no scan: 1 publisher, {ODD}"), (0, [ODD], ""), (3, [ODD, ""], COMES)]),
        (EVENT, [(0, [ODD], ""), (0, [ODD], f"'scan: 1 publisher, {ODD}'"), (0, [ODD], ""), (3, [ODD, ""], "")]),
        # nothing where nobody publishes, or nobody publishes anything
        (EVENT, [(0, [], "")] * 4 + [(0, [""], "")] * 4),
        # as soon as it is there, and anew after it was gone
        (
            STREAM,
            [(3, [""], COMES), (3, ["", RARE], RARE), (3, ["", RARE], ""), (3, [""], ""), (3, ["", RARE], RARE)],
        ),
        # each obstacle with its own number of publishers
        (EVENT, [(0, [], ""), (0, [ODD, EVEN, ODD], f"scan: 2 publishers, {ODD}"), (0, [ODD, EVEN, ODD], "")]),
        (EVENT, [(0, [], ""), (0, [ODD, EVEN, ODD], f"scan: 1 publisher, {EVEN}")]),
        # that it ends is news although the other publisher has been told
        (STREAM, [(3, ["", ODD], ODD), (0, [ODD], ""), (0, [ODD], f"no scan: 1 publisher, {ODD}"), (0, [ODD], "")]),
        # a state whose publishers cannot be heard is not there
        (STATE, [(1, [""], COMES), (0, [ODD], ""), (0, [ODD], f"no scan: 1 publisher, {ODD}")]),
    ],
)
def test_publishers_that_cannot_be_heard_are_told_once(need, seconds):
    publishers = []
    watch = InputWatch("scan", need, lambda: publishers)
    for taken, publishers, said in seconds:  # noqa: B007 (the watch asks for it)
        watch.n_taken += taken
        lines = watch.check()
        assert bool(said) == bool(lines), (seconds, lines)
        assert said in str(lines), lines
        assert said != COMES or list(lines) == [COMES]


@pytest.mark.parametrize("need", [STREAM, STATE, EVENT])
def test_messages_that_are_dropped_are_told_with_the_reason_until_they_are_taken(need):
    watch = InputWatch("scan", need, lambda: [""])
    said = []
    for taken, dropped in [(0, ""), (0, "no time"), (0, "no time"), (2, ""), (0, ""), (0, "")]:
        watch.n_taken, watch.dropped = watch.n_taken + taken, dropped
        said.append("no time" in str(watch.check()))
    assert said == [False, True, False, False, False, False]


def test_a_hint_is_told_once_for_as_long_as_it_is_true():
    watch = InputWatch("scan", STREAM, lambda: [""])
    told = []
    for taken, hint in ((1, ""), (1, "20% are 0"), (1, "30% are 0"), (0, "30% are 0"), (1, "4% are 0")):
        watch.n_taken, watch.hint = watch.n_taken + taken, hint
        told.append("hint" in watch.check())
    assert told == [False, True, False, False, False]
